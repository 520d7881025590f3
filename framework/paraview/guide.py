"""What lies beside a series for ParaView: a page that tells what its arrays are, and a script that opens it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import floor, log10
from pathlib import Path

import numpy as np

from .scene import Part

# What each array is, with its unit in words: those of the description, such as newton and metre.
MEANINGS = {
    "displacement": "displacement by loads, compliance and clearance, global axes, 0 along a free motion; length",
    "rotation": "rotation vector, global axes; radians",
    "N": "normal force, tension positive; force",
    "V": "shear force, global axes; force",
    "V_local": "shear force (0, Vy, Vz) in the axes of the section; force",
    "T": "torque; force times length",
    "M": "bending moment, global axes; force times length",
    "M_local": "bending moment (0, My, Mz) in the axes of the section; force times length",
    "stress_min": "least normal stress of the section; force per area",
    "stress_max": "greatest normal stress of the section; force per area",
    "von_mises": "greatest von Mises stress of the section; force per area",
    "gap": "displacement of the second node of a joint relative to the first, global axes; length",
    "gap_rotation": "rotation of the second node relative to the first, global axes; radians",
    "force": "force of the joint on its first node, global axes; force",
    "moment": "moment of the joint on its first node, global axes; force times length",
    "clearance_offset": "place of the journal within its clearance, global axes; length (radians of a rotation)",
    "contact": "whether a joint with clearance is in contact: 1 in contact, 0 not, -1 a joint without clearance",
    "velocity": "velocity, global axes; length per time",
    "acceleration": "acceleration, global axes; length per time squared",
    "member": "number of the member, named in member_names; no unit",
    "link": "number of the link, named in link_names, -1 the ground; no unit",
    "joint": "number of the joint, named in joint_names; no unit",
    "solved": "1 where there is a solution; 0 where there is none, as of a mechanism, and results are 0; no unit",
}

_README = """\
{file}: a series of poses for ParaView, one step a pose.

Open {file}, or run open_in_paraview.py in ParaView (Tools > Python Shell > Run Script, or paraview --script=...), which
shows it displaced and coloured, with the names of the parts in the legend.

Blocks of each pose: {blocks}. The arrays are in the units of the description: with metres, newtons and seconds,
stresses are in pascals. Angles are in radians.

{arrays}

The field data member_names, link_names and joint_names name the numbers in the cell arrays member, link and joint.
"""

_SCRIPT = '''\
"""Open the series in ParaView: displaced, as tubes, coloured, joints as balls, parts by their names."""

from pathlib import Path

from paraview.simple import *

NAMES = {names!r}
SCALE = {scale!r}  # factor on the displacements
RADIUS = {radius!r}
BLOCKS = {blocks!r}
COLOURS = [(0.0, 0.45, 0.7), (0.9, 0.6, 0.0), (0.0, 0.6, 0.45), (0.8, 0.5, 0.65), (0.35, 0.7, 0.9), (0.85, 0.35, 0.0)]

folder = Path(__file__).resolve().parent
series = PVDReader(registrationName=folder.name, FileName=str(folder.with_name(folder.name + ".pvd")))
GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
view = GetActiveViewOrCreate("RenderView")
for array, names in NAMES.items():
    colours = GetColorTransferFunction(array)
    colours.InterpretValuesAsCategories = 1
    colours.Annotations = [text for number, name in enumerate(names) for text in (str(number), name)]
    colours.IndexedColors = [part for number in range(len(names)) for part in COLOURS[number % len(COLOURS)]]
for block, (where, colour, title, moves) in BLOCKS.items():
    shown = ExtractBlock(registrationName=block, Input=series, Selectors=["/Root/" + block])
    if moves:
        shown = WarpByVector(Input=shown, Vectors=["POINTS", "displacement"], ScaleFactor=SCALE)
    if block == "joints":
        shown, where = CellDatatoPointData(Input=shown), "POINTS"
        shown = Glyph(Input=shown, GlyphType="Sphere", ScaleFactor=4 * RADIUS, GlyphMode="All Points")
        shown.ScaleArray, shown.OrientationArray = ["POINTS", "No scale array"], ["POINTS", "No orientation array"]
    else:
        shown = Tube(Input=ExtractSurface(Input=shown), Radius=RADIUS)
    display = Show(shown, view)
    ColorBy(display, (where, colour))
    if colour not in NAMES:
        display.RescaleTransferFunctionToDataRangeOverTime()
    bar = GetScalarBar(GetColorTransferFunction(colour), view)
    bar.Title, bar.ComponentTitle = title, ""
    display.SetScalarBarVisibility(view, True)
if any(moves for *_, moves in BLOCKS.values()):
    Show(Text(Text="displacements \u00d7 " + format(SCALE, "g")), view)
ResetCamera(view)
Render(view)
'''

# What colours a block where it is opened: the first that it has.
_COLOURS = ("von_mises", "joint", "link")
# Largest displacement and radius of the tubes, as shares of the size of what is shown.
_SHOWN, _THICKNESS = 0.08, 0.006
# Names that the legend takes.
_NAMED = 200


def write_guide(folder: Path, file: str, parts: Sequence[Part], names: Mapping[str, Sequence[str]]) -> None:
    """Write README.txt and open_in_paraview.py.

    Parameters
    ----------
    folder
        Where they go: the folder with the files of the series.
    file
        Name of the .pvd.
    parts
        Blocks of the series.
    names
        Names by number of the ``member``, ``link`` and ``joint``.
    """
    arrays = "\n".join(f"{part.name}\n{_described(part)}" for part in parts)
    text = _README.format(file=file, blocks=", ".join(part.name for part in parts), arrays=arrays)
    (folder / "README.txt").write_text(text, encoding="utf-8")
    size = max(float(np.ptp(part.points, axis=(0, 1)).max()) for part in parts) or 1.0
    named = {kind: list(of[:_NAMED]) for kind, of in names.items() if of}
    blocks = {part.name: (*_coloured(part), "displacement" in part.point_data) for part in parts}
    script = _SCRIPT.format(names=named, scale=_scale(parts, size), radius=_THICKNESS * size, blocks=blocks)
    (folder / "open_in_paraview.py").write_text(script, encoding="utf-8")


def _coloured(part: Part) -> tuple[str, str, str]:
    """The array that colours a block: ``POINTS`` or ``CELLS``, its name, and the title of the colour bar."""
    colour = next(name for name in _COLOURS if name in part.point_data or name in part.cell_data)
    unit = MEANINGS[colour].rpartition("; ")[2]
    title = colour if unit == "no unit" else f"{colour} [{unit}]"
    return "POINTS" if colour in part.point_data else "CELLS", colour, title


def _described(part: Part) -> str:
    rows = []
    for where, data in (("points", part.point_data), ("cells", part.cell_data)):
        rows += [f"  {name:17s} on {where}: {MEANINGS[name]}" for name in data]
    return "\n".join(rows) + "\n"


def _scale(parts: Sequence[Part], size: float) -> float:
    """A round factor that shows the displacements: 1, 2 or 5 times a power of ten, 1 where there are none."""
    most = max(
        (
            float(np.abs(part.point_data["displacement"]).max(initial=0.0))
            for part in parts
            if "displacement" in part.point_data
        ),
        default=0.0,
    )
    if not most > 0.0:
        return 1.0
    wanted = _SHOWN * size / most
    power = 10.0 ** floor(log10(wanted))
    return float(max(step for step in (1.0, 2.0, 5.0) if step * power <= wanted or step == 1.0) * power)
