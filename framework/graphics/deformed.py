"""A solved frame as lines and symbols: undeformed and deformed, with section forces or stresses of its members."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..errors import FrameError
from ..paraview.entries import Index, one
from ..paraview.scene import beams, solved, taken
from ..results.base import Results
from .diagrams import DIAGRAMS, add_diagrams, along_members, untold
from .free_modes import free_modes, told_modes
from .scene import FLAT, JointSymbol, Label, LoadArrow, Scene, Stroke, Support, beside
from .units import quantity, scaled, stress_unit

STATIONS = 24
# Largest displacement as a share of the frame's size.
SHOWN = 0.07
# What can be drawn, and what it is called.
KINDS = {"deformed": "displacement", "von_mises": "von Mises stress", **DIAGRAMS}
# Share of the frame's size by which nodes of a joint must be displaced apart for a name each.
APART = 0.02
# Displacement in a free motion below this share of the greatest is none.
LEAST = 1e-6


@dataclass(frozen=True, eq=False)
class DeformedFrame:
    """Drawing of a solution at one batch entry.

    Attributes
    ----------
    scene
        Lines and symbols.
    scale
        Factor on the displacements.
    values
        Name with unit, and greatest value, of the quantity that colours the members; None without colours.
    title
        Title of the figure.
    """

    scene: Scene
    scale: float
    values: tuple[str, float] | None
    title: str


def deformed_frame(
    solution: Results,
    what: str,
    entry: int | tuple[int, ...] | None,
    scale: float | None,
    names: bool,
    units: tuple[str, str],
) -> DeformedFrame:
    """The drawing for `plot` of a solution.

    Parameters
    ----------
    solution
        The solution.
    what
        One of `KINDS`.
    entry
        Indices of the batch entry; not needed where the batch holds one.
    scale
        Factor on the displacements; if None, a round one that makes them visible.
    names
        Whether nodes are labelled.
    units
        Units of length and force.

    Returns
    -------
    DeformedFrame
        With its title.

    Raises
    ------
    FrameError
        If there is no such kind of figure, no member, or no such entry.
    """
    if what not in KINDS:
        axes = "" if isinstance(what, str) else ", and give axes as ax="
        raise FrameError(f"plot was given what={what!r}: choose one of {', '.join(KINDS)}{axes}")
    frame = solution.frame
    if not frame.members:
        raise FrameError("the frame has no member to draw: add one")
    index = one(solution.shape, entry, "the figure of the solution")
    part = beams(solution, index, STATIONS)

    def by_member(array: Array) -> Array:
        return np.asarray(array[0].reshape(len(frame.members), STATIONS + 1, *array.shape[2:]))

    rest, moved = by_member(part.points), by_member(part.point_data["displacement"])
    size = float(np.linalg.norm(np.ptp(rest.reshape(-1, 3), axis=0))) or 1.0
    factor = round_scale(moved, SHOWN * size) if scale is None else float(scale)
    scene = Scene(flat=_plane(rest, moved))
    values, title = None, f"displacements × {factor:g}"
    there = bool(solved(solution, index)[0])
    for line in rest:
        scene.strokes.append(Stroke(line[[0, -1]], "undeformed" if what in ("deformed", "von_mises") else "member"))
    if what in ("deformed", "von_mises"):
        colours = None
        if what == "von_mises" and there:
            told = along_members(solution, index, what, by_member(part.point_data[what]))
            title += untold(told, KINDS[what])
            most = max(float(each.values.max()) for each in told if each.known)
            times, unit = scaled(most, stress_unit(units))
            share = np.linspace(0.0, 1.0, STATIONS + 1)
            colours = np.array([np.interp(share, each.fraction, each.values) for each in told])
            colours, values = times * colours, (f"{KINDS[what]} [{unit}]", times * most)
        for k, line in enumerate(rest + factor * moved):
            scene.strokes.append(Stroke(line, "member", number=k, values=None if colours is None else colours[k]))
    else:
        told = along_members(solution, index, what, by_member(part.point_data[what]))
        title = add_diagrams(scene, solution, index, rest, told, what, size, units)
        factor = 0.0
    _add_marks(scene, solution, index, factor if there else 0.0, names, units[1])
    if not there:
        modes = free_modes(solution, [int(k) for k in index[1:] if isinstance(k, int | np.integer)])
        told_mode = f"; arrows: {told_modes(modes)}" if len(modes) else ""
        title = f"{np.asarray(solution.status)[index[1:]]!s}: undeformed shape, no solution{told_mode}"
        if len(modes):
            scene.moves.extend(_moves(solution, index, modes[0]))
    return DeformedFrame(scene, factor, values, title)


def round_scale(moved: Array, most: float) -> float:
    """The greatest of 1, 2 and 5 times a power of ten that draws no displacement (..., 3) longer than `most`."""
    length = np.linalg.norm(moved, axis=-1)
    greatest = float(length.max(initial=0.0, where=np.isfinite(length)))
    if greatest == 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(most / greatest))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power * greatest <= most * (1.0 + 1e-12)))


def _plane(rest: Array, moved: Array) -> tuple[int, int] | None:
    """The coordinate plane in which the members lie and are displaced; None in space."""
    places, ways = rest.reshape(-1, 3), np.nan_to_num(moved.reshape(-1, 3))
    extent, most = np.ptp(places, axis=0), np.abs(ways).max(axis=0, initial=0.0)
    for across in (2, 1, 0):
        if extent[across] <= FLAT * extent.max() and most[across] <= 1e-6 * most.max(initial=0.0):
            return beside(across)
    return None


def _add_marks(scene: Scene, solution: Results, index: Index, factor: float, names: bool, force: str) -> None:
    """Joints, supports, forces at nodes and their names, where they have been displaced to."""
    frame = solution.frame
    nodes, rest = list(frame.nodes), _at_rest(solution, index)
    moved = np.nan_to_num(np.broadcast_to(solution.displacements(), (*solution.shape, len(nodes), 6))[index][0, :, :3])
    at = dict(zip(nodes, rest + factor * moved, strict=True))
    for name, link in frame.joints.items():
        axes = link.element.axes
        rotated = np.eye(3) if axes is None else taken(solution, index, [axes])[0, 0]
        scene.joints.append(JointSymbol(name, joint_kind(link.element), at[link.first], rotated))
    counts = _counting(scene.flat)
    ways = (0, 1, 2) if scene.flat is None else scene.flat
    for node, constrained in frame.supports.items():
        if not any(k in constrained for k in ways):
            continue  # what only keeps a plane frame in its plane, or from rotating, is no ground that shows
        scene.supports.append(Support(at[node], clamped=all(k in constrained for k in counts)))
    for node, loads in frame.loads.items():
        total = np.zeros((*solution.shape, 3))
        for component, value in loads:
            if component < 3:
                total[..., component] += value
        given = total[index][0]
        if (size := float(np.linalg.norm(given))) > 0.0:
            scene.arrows.append(LoadArrow(at[node], given, quantity(size, force)))
    if names:
        together = np.round(rest / (1e-6 * scene.size))  # the nodes on both sides of a joint, however near others are
        groups = {node: tuple(place) for node, place in zip(nodes, together.tolist(), strict=True)}
        scene.labels.extend(Label(text, place) for text, place in named_places(at, APART * scene.size, groups))


def _at_rest(solution: Results, index: Index) -> Array:
    """Positions of the nodes at one batch entry without displacement, (nodes, 3)."""
    frame = solution.frame
    return taken(solution, index, [frame.position(node)[..., None, :] for node in frame.nodes])[0, :, 0]


def _moves(solution: Results, index: Index, mode: Array) -> Iterator[LoadArrow]:
    """Arrows of a free motion (nodes, 3), one at a place."""
    seen: set[tuple[float, ...]] = set()
    for at, way in zip(_at_rest(solution, index), mode, strict=True):
        own = (*np.round(at, 9).tolist(), *np.round(way, 6).tolist())
        if np.linalg.norm(way) > LEAST and own not in seen:
            seen.add(own)
            yield LoadArrow(at, way, "")


def joint_kind(element: object) -> str:
    """Kinematic pair with the free components of a joint, by name; ``revolute`` if they are those of no pair."""
    stiffness = np.asarray(getattr(element, "stiffness", np.ones(6)), dtype=float)
    if stiffness.shape[-1:] != (6,):
        return "revolute"
    free = tuple(np.all(stiffness == 0.0, axis=tuple(range(stiffness.ndim - 1))).tolist())
    slides, turns = sum(free[:3]), sum(free[3:])
    known = {(0, 0): "fixed", (0, 1): "revolute", (0, 2): "universal", (0, 3): "spherical"}
    known |= {(1, 0): "prismatic", (1, 1): "cylindrical", (2, 1): "planar"}
    return known.get((slides, turns), "revolute")


def _counting(flat: tuple[int, int] | None) -> tuple[int, ...]:
    """Components that matter to a support: in a plane the three in it."""
    return tuple(range(6)) if flat is None else (*flat, 6 - sum(flat))


def named_places(
    at: dict[str, Array], near: float, kinds: Mapping[str, object] | None = None
) -> list[tuple[str, Array]]:
    """Labels and their places; nodes in one place, such as those on both sides of a joint, share one label.

    Parameters
    ----------
    at
        Places (3,) by name.
    near
        Distance up to which they count as one.
    kinds
        What they must have in common for that; nothing where None.
    """
    kind = dict.fromkeys(at) if kinds is None else kinds
    groups: list[tuple[list[str], Array]] = []
    for name, place in at.items():
        alike = (group for group in groups if kind[group[0][0]] == kind[name])
        same = next((names for names, other in alike if np.linalg.norm(place - other) <= near), None)
        if same is None:
            groups.append(([name], place))
        else:
            same.append(name)
    return [(_common(names), place) for names, place in groups]


def _common(names: list[str]) -> str:
    """``B`` of ``B.crank`` and ``B.coupler``, and all others as they are."""
    starts = [name.rpartition(".")[0] or name for name in names]
    return ", ".join(
        dict.fromkeys(start if starts.count(start) > 1 else name for start, name in zip(starts, names, strict=True))
    )
