"""Members and joints of a solution as points, cells and arrays for ParaView, at all poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..description import Description
from ..results.base import Results
from ..states import SolutionState, among
from ..structure.topology import Topology
from .entries import Index

Array = NDArray[Any]


@dataclass(frozen=True)
class Part:
    """Cells of one kind at T poses.

    Attributes
    ----------
    name
        ``beams`` or ``joints``.
    cell
        ``line`` or ``vertex``.
    points
        Undeformed points, (T, n, 3).
    cells
        Point numbers, (m, 2) for lines, (m, 1) for vertices.
    point_data, cell_data
        Arrays by name, (T, n), (T, n, 3) and (T, m), (T, m, 3).
    """

    name: str
    cell: str
    points: Array
    cells: Array
    point_data: Mapping[str, Array]
    cell_data: Mapping[str, Array]


def beams(solution: Results, index: Index, stations: int) -> Part:
    """Members at the batch entries `index`, each as `stations` line cells.

    Members are the cells ``beam`` of `Frame.mesh`. They share no points, so that section forces may jump from one to
    the next. Points carry ``displacement`` and ``rotation`` (global), ``N``, ``T``, shear force and bending moment as
    global vectors, ``V`` and ``M``, and ``stress_min``, ``stress_max``, ``von_mises``, all at their station. Cells
    carry, at their middle, shear force and bending moment in the axes of the section, ``V_local`` = (0, Vy, Vz) and
    ``M_local`` = (0, My, Mz), and ``member`` and ``link``, the numbers of the member and of its body (-1: the ground).
    An array is on points or on cells, never on both, as a viewer would show either under the one name.
    Where the batch entry has no solution ``solved`` is 0 and so is every result; so are displacements along the free
    motion of a statically consistent mechanism. Stresses of a section that is known by its properties only are NaN.
    """
    frame = solution.frame
    # Even numbers are the stations, odd ones the middles of the cells between them.
    fraction = np.linspace(0.0, 1.0, 2 * stations + 1)
    displacement = placed(shown(solution, index, solution.displacements_at(fraction[::2])))
    force = shown(solution, index, solution.forces_at(fraction))
    stress = shown(solution, index, solution.stresses_at(fraction[::2]))
    axes = _section_axes(solution, index, fraction[::2])

    count = len(frame.members)
    first = np.arange(count)[:, None] * (stations + 1) + np.arange(stations)
    links = [_link(solution, member.start, member.end) for member in frame.members.values()]
    return Part(
        name="beams",
        cell="line",
        points=_joined(_places(solution, index, fraction[::2])),
        cells=first.reshape(-1, 1) + np.arange(2),
        point_data=_halves("displacement", "rotation", _joined(displacement))
        | _section(_joined(across(force[:, :, ::2], axes)), _joined(stress)),
        cell_data=_local(_joined(across(force[:, :, 1::2])))
        | _labels(solution, index, member=np.repeat(np.arange(count), stations), link=np.repeat(links, stations)),
    )


def joints(solution: Results, index: Index) -> Part:
    """Joints at the batch entries `index`, each as a vertex cell at its first node.

    Points carry, in global axes, ``displacement`` and ``rotation`` of the first node, ``gap`` and
    ``gap_rotation``, the displacement of the second node relative to the first, and ``force`` and
    ``moment``, which the joint exerts on the first node; where
    there is clearance, ``clearance_offset``, the place of each journal in its clearance, and ``contact``, 1 where it
    touches, 0 where not and -1 at a joint without. Cells carry ``joint``, the joint's number, and
    ``solved``, as for the beams.
    """
    frame = solution.frame
    vectors = {
        ("displacement", "rotation"): [solution.displacement(link.first) for link in frame.joints.values()],
        ("gap", "gap_rotation"): [
            solution.joint_global(name, solution.joint_displacement(name)) for name in frame.joints
        ],
        ("force", "moment"): [solution.joint_global(name, solution.joint_force(name)) for name in frame.joints],
    }
    data: dict[str, Array] = {}
    for (linear, angular), arrays in vectors.items():
        values = results(solution, index, [a[..., None, :] for a in arrays])
        data |= _halves(linear, angular, _joined(placed(values)))
    data |= _clearances(solution, index)
    number = np.arange(len(frame.joints))
    return Part(
        name="joints",
        cell="vertex",
        points=_positions(solution, index)[:, _ends(frame)[1][:, 0]],
        cells=number[:, None],
        point_data=data,
        cell_data=_labels(solution, index, joint=number),
    )


def _places(solution: Results, index: Index, fraction: Array) -> Array:
    """Undeformed points of all members at these fractions of their lengths, (T, members, k, 3)."""
    nodes, ends = _positions(solution, index), _ends(solution.frame)[0]
    start, end = nodes[:, ends[:, 0], None], nodes[:, ends[:, 1], None]
    places: Array = start + fraction[:, None] * (end - start)
    return places


def _ends(frame: Description) -> tuple[Array, Array]:
    """Node numbers of the members' ends and of the joints, (members, 2) and (joints, 2), from the frame's mesh."""
    topology = Topology.of(frame, cut=True)
    cells, parts = topology.mesh.t, topology.mesh.subdomains
    last = np.cumsum(topology.counts) - 1
    first = last - topology.counts + 1
    members = np.stack([cells[0, parts["beam"][first]], cells[1, parts["beam"][last]]], axis=-1)
    return members, cells[:, parts["joint"]].T


def _positions(solution: Results, index: Index) -> Array:
    """Positions of all nodes, (T, nodes, 3)."""
    frame = solution.frame
    fixed = np.array([node.body is None and node.coordinates.ndim == 1 for node in frame.nodes.values()])
    places = [frame.position(name) for name in frame.nodes]
    out = np.zeros((np.broadcast_to(0.0, solution.shape)[index].size, len(places), 3))
    out[:, fixed] = np.array([place for place, still in zip(places, fixed, strict=True) if still]).reshape(-1, 3)
    for k in np.flatnonzero(~fixed):
        out[:, k] = np.broadcast_to(places[k], (*solution.shape, 3))[index]
    return out


def _link(solution: Results, start: str, end: str) -> int:
    """Number of the body that carries both nodes, -1 if none does."""
    nodes, bodies = solution.frame.nodes, list(solution.frame.bodies)
    body = nodes[start].body
    return bodies.index(body) if body is not None and body == nodes[end].body else -1


def taken(solution: Results, index: Index, arrays: Sequence[Array]) -> Array:
    """Entries `index` of arrays (..., k, c), stacked to (T, len(arrays), k, c)."""
    return np.stack([np.broadcast_to(a, solution.shape + a.shape[-2:])[index] for a in arrays], axis=1)


def solved(solution: Results, index: Index) -> Array:
    """Which of the entries have a solution, (T,)."""
    without = among(solution.state, SolutionState.MECHANISM, SolutionState.ABSENT, SolutionState.NOT_CONVERGED)
    unresolved = among(solution.state, SolutionState.UNRESOLVED)
    if unresolved.any():  # with results that rounding may have changed, or with none
        first = solution.displacement(next(iter(solution.frame.nodes)))
        without = without | unresolved & np.isnan(first).all(axis=-1)
    return np.broadcast_to(~without, solution.shape)[index]


def shown(solution: Results, index: Index, array: Array) -> Array:
    """Entries `index` of an array (..., n, k, c) as (T, n, k, c), or of one with more axes, with zeros where there is
    no solution: a viewer cannot place NaN, and `solved` tells."""
    found = array[index]
    return np.where(solved(solution, index).reshape(-1, *(1,) * (found.ndim - 1)), found, 0.0)


def results(solution: Results, index: Index, arrays: Sequence[Array]) -> Array:
    """As `taken`, with zeros where there is no solution."""
    return np.where(solved(solution, index)[:, None, None, None], taken(solution, index, arrays), 0.0)


def _joined(array: Array) -> Array:
    """Members and stations in one axis: (T, m, k, c) to (T, m k, c)."""
    return array.reshape(array.shape[0], -1, array.shape[-1])


def placed(displacement: Array) -> Array:
    """Displacements with zeros in place of NaN, along the free motion of a statically consistent mechanism."""
    return np.where(np.isnan(displacement), 0.0, displacement)


def _halves(linear: str, angular: str, array: Array) -> dict[str, Array]:
    return {linear: array[..., :3], angular: array[..., 3:]}


def across(force: Array, axes: Array | None = None) -> Array:
    """``N Vy Vz T My Mz`` as normal force, shear force (3), torque and bending moment (3), (T, m, k, 8).

    Shear force and bending moment are in the axes of the section; in global ones where `axes` holds these as rows.
    """

    def vector(two: Array) -> Array:
        if axes is None:
            return np.concatenate([np.zeros_like(two[..., :1]), two], axis=-1)
        turned: Array = two[..., :1] * axes[..., 1, :] + two[..., 1:] * axes[..., 2, :]
        return turned

    parts = [force[..., :1], vector(force[..., 1:3]), force[..., 3:4], vector(force[..., 4:])]
    return np.concatenate(parts, axis=-1)


def _section_axes(solution: Results, index: Index, fraction: Array) -> Array:
    """Axes of the sections as rows in global components, (T, members, k or 1, 3, 3)."""
    rows = solution.section_axes_at(fraction)
    return shown(solution, index, np.broadcast_to(rows, (*solution.shape, *rows.shape[-4:])))


def _section(force: Array, stress: Array) -> dict[str, Array]:
    """Section forces (T, n, 8) in global axes and stresses (T, n, 3) by name."""
    return {
        "N": force[..., 0],
        "V": force[..., 1:4],
        "T": force[..., 4],
        "M": force[..., 5:],
        "stress_min": stress[..., 0],
        "stress_max": stress[..., 1],
        "von_mises": stress[..., 2],
    }


def _local(force: Array) -> dict[str, Array]:
    """Section forces (T, n, 8) across the member in the axes of the section, by name."""
    return {"V_local": force[..., 1:4], "M_local": force[..., 5:]}


def _labels(solution: Results, index: Index, **numbers: Array) -> dict[str, Array]:
    """Numbers of the cells, the same at every pose, and `solved`, the same on every cell."""
    flags = solved(solution, index)[:, None]
    shape = (len(flags), len(next(iter(numbers.values()))))
    return {n: np.broadcast_to(a, shape).astype(np.int32) for n, a in {**numbers, "solved": flags}.items()}


def _clearances(solution: Results, index: Index) -> dict[str, Array]:
    """Where journals rest in their clearances, (T, joints, 3), and whether they touch; nothing without clearance."""
    names, journals = list(solution.frame.joints), solution.journals
    if not journals:
        return {}
    offset = np.zeros((len(solved(solution, index)), len(names), 3))
    touching = np.full(offset.shape[:2], -1, dtype=np.int32)
    for name in journals:
        contact, k = solution.contact(name), names.index(name)
        place = np.broadcast_to(solution.joint_global(name, contact.offset), (*solution.shape, 3))[index]
        offset[:, k] = np.where(solved(solution, index)[:, None], place, 0.0)
        touching[:, k] = np.broadcast_to(contact.closed, solution.shape)[index]
    return {"clearance_offset": np.nan_to_num(offset), "contact": touching}
