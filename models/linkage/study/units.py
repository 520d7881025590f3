"""Units of the numbers of a file, which is in SI."""

from __future__ import annotations

from ..description.joints import COMPONENTS, KINDS
from ..files.source import Source
from ..files.toml import Path

# By the table and the key in it. What is not here has none, as directions, or depends on more.
UNITS = {
    "links": {"mass": "kg", "centre": "m", "inertia": "kg m²", "length": "m"},
    "joints": {"clearance": "m", "contact": "rad", "pitch": "m"},
    "springs": {"stiffness": "N/m", "length": "m", "damping": "N s/m"},
    "sections": {"A": "m²", "Iy": "m⁴", "Iz": "m⁴", "J": "m⁴", "ky": "", "kz": "", "Wt": "m³", "fibres": ""},
    "materials": {"E": "Pa", "G": "Pa", "nu": "", "density": "kg/m³"},
}


def unit_of(source: Source, place: Path) -> str:
    """Unit of a number of the file; nothing for one that has none, as a ratio.

    Parameters
    ----------
    source
        The file.
    place
        Where the number stands.
    """
    match place:
        case ("points", *_):
            return "m"
        case ("gravity", *_):
            return "m/s²"
        case ("loads", _, str(component), *_):
            return "N m" if component.startswith("m") else "N"
        case ("joints", _, "stiffness", int(index)):
            return "N m/rad" if COMPONENTS[index].startswith("r") else "N/m"
        case ("joints", name, "reference", *which):
            coordinate = KINDS[source.get(("joints", name, "kind"))].coordinates[int(which[0]) if which else 0]
            return "rad" if coordinate.startswith("r") else "m"
        case ("sections", _, str(key), *_):
            return UNITS["sections"].get(key, "m")
        case (str(table), _, str(key), *_):
            return UNITS.get(table, {}).get(key, "")
    return ""
