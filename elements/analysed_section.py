"""Properties of a cross-section from a finite-element analysis by the package sectionproperties."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..framework.errors import FrameError
from ..framework.protocol import Array

OWNER = "Section.from_sectionproperties"
# Up to these the following are errors of the mesh: the product of inertia over the sum of the second moments, and the
# offset of the shear centre over the size of the section.
SKEW, OFFSET = 1e-6, 5e-3
# Names of the analysed properties: False by the axes x and y, True by the principal axes 1 and 2.
NAMES = {
    False: ("ixx_c", "iyy_c", "a_sx", "a_sy", "x_se", "y_se"),
    True: ("i11_c", "i22_c", "a_s11", "a_s22", "x11_se", "y22_se"),
}


def properties_of(analysed: object, unit: float, principal: bool) -> tuple[dict[str, Any], str]:
    """Parameters of a `Section`, by name; and a warning of what it neglects of the analysed section, "" for none."""
    section = _analysed(analysed)
    found = section.section_props
    first, second, shear_y, shear_z, off_y, off_z = (float(getattr(found, name)) for name in NAMES[principal])
    skew = float(found.ixy_c)
    if not principal and abs(skew) > SKEW * (first + second):
        raise FrameError(
            f"{OWNER}: the product of inertia is {skew:.4g} beside second moments of {first:.4g} and {second:.4g}, and "
            "a beam bends about principal axes: give principal=True, and turn the beam by up= (the first principal "
            f"axis, which becomes local y, lies at {float(found.phi):.4g}° from x)"
        )
    area, turn = float(found.area), np.radians(float(found.phi)) if principal else 0.0
    fibres = _fibres(section, turn)
    size = np.abs(fibres[:, :2]).max(axis=0)
    given = {
        "A": area * unit**2,
        "Iy": first * unit**4,
        "Iz": second * unit**4,
        "J": float(found.j) * unit**4,
        "ky": shear_y / area,
        "kz": shear_z / area,
        "cy": size[0] * unit,
        "cz": size[1] * unit,
        "Wt": unit**3 / np.hypot(fibres[:, 4], fibres[:, 7]).max(),
        # A shear stress by a unit force is one over an area, by a unit torque one over a volume.
        "fibres": fibres * np.array([unit, unit, *2 * (unit**-2, unit**-2, unit**-3)]),
    }
    off = np.array([off_y, off_z])
    if np.all(np.abs(off) <= OFFSET * size.max()):
        return given, ""
    y, z = off * unit
    return given, (
        f"the shear centre lies at y = {y:.4g}, z = {z:.4g} from the centroid, and a beam has both in one: that forces "
        "through the centroid twist such a member is left out"
    )


def _analysed(given: object) -> Any:
    """The section with its geometric and warping properties; a geometry with a mesh is analysed first."""
    if hasattr(given, "create_mesh"):
        from sectionproperties.analysis import Section as Analysis

        if not getattr(given, "mesh", None):
            raise FrameError(f"{OWNER}: the geometry has no mesh: call its create_mesh(...) first")
        section: Any = Analysis(given)
        section.calculate_geometric_properties()
        section.calculate_warping_properties()
    elif hasattr(given, "section_props"):
        section = given
    else:
        raise FrameError(
            f"{OWNER} was given a {type(given).__name__}: give a geometry or a section of sectionproperties"
        )
    if section.is_composite():
        raise FrameError(
            f"{OWNER}: the section has materials of its own, and a Section has one, which its beam gives: make the "
            "geometry without materials"
        )
    for needed, name in (("geometric", "ixx_c"), ("warping", "a_sx")):
        if getattr(section.section_props, name) is None:
            raise FrameError(f"{OWNER}: the section is not analysed: call its calculate_{needed}_properties() first")
    return section


def _fibres(section: Any, turn: float) -> Array:
    """Fibres at all nodes of the mesh, (n, 8), in axes rotated by `turn` (radians).

    The columns are y, z, the shear stress along y by unit Vy, Vz and T, and that along z.
    """
    centroid = np.array([float(section.section_props.cx), float(section.section_props.cy)])
    (group,) = section.calculate_stress(vx=1.0, vy=1.0, mzz=1.0).material_groups
    by_x, by_y, by_torque = (
        np.stack([getattr(group.stress_result, f"sig_z{axis}_{by}") for axis in "xy"], axis=-1)
        for by in ("vx", "vy", "mzz")
    )
    c, s = np.cos(turn), np.sin(turn)
    along = np.array([[c, -s], [s, c]])
    # A unit force along a rotated axis has components c and s along the original axes.
    by_forces = (c * by_x + s * by_y, c * by_y - s * by_x, by_torque)
    stresses = [part @ along for part in by_forces]
    rows = [part[:, axis] for axis in (0, 1) for part in stresses]
    places = (np.asarray(section.mesh_nodes, dtype=float) - centroid) @ along
    return np.column_stack([places, *rows])
