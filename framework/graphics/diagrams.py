"""Section forces and stresses along members as diagrams and colours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..errors import FrameError
from ..paraview.entries import Index
from ..paraview.scene import across, solved, taken
from ..results.base import Results
from .scene import Label, Region, Scene, Stroke
from .units import moment_unit, scaled

# Largest ordinate of a diagram as a share of the frame's size.
ORDINATE = 0.13
# What a diagram can show, and what it is called, and where it stands in `across`.
DIAGRAMS = {"N": "normal force N", "V": "shear force V", "T": "torque T", "M": "bending moment M"}
PLACES = {"N": [0], "V": [1, 2, 3], "T": [4], "M": [5, 6, 7]}


@dataclass(frozen=True, eq=False)
class MemberValues:
    """A section force or stress along a member.

    Attributes
    ----------
    member
        Name of the member.
    fraction
        Distances from its start over its length, (k,).
    values
        Values there, (k,) or (k, 3); NaN where unknown.
    """

    member: str
    fraction: Array
    values: Array

    @property
    def known(self) -> bool:
        """Whether all values are known."""
        return bool(np.isfinite(self.values).all())


def along_members(solution: Results, index: Index, what: str, values: Array) -> list[MemberValues]:
    """Section forces or stresses of all members at one entry; at the ends of segments if unknown between them.

    Parameters
    ----------
    solution
        The solution.
    index
        Index into the batch that leaves one axis of length 1.
    what
        One of `DIAGRAMS`, or ``von_mises``.
    values
        What it is at equal steps along all members, (members, k, ...), NaN throughout for members that do not tell.

    Returns
    -------
    list of MemberValues
        One for each member.
    """
    fraction = np.linspace(0.0, 1.0, values.shape[1])
    found = [MemberValues(name, fraction, value) for name, value in zip(solution.frame.members, values, strict=True)]
    if not solved(solution, index)[0]:
        return found
    return [each if each.known else _at_segment_ends(solution, index, what, each) for each in found]


def _at_segment_ends(solution: Results, index: Index, what: str, unknown: MemberValues) -> MemberValues:
    """Values of a member at the ends of its segments; `unknown` itself if these are not known either."""
    frame, name = solution.frame, unknown.member
    fraction = np.linspace(0.0, 1.0, frame.members[name].element.segments + 1)
    at = frame.length(name)[..., None] * fraction
    try:
        if what == "von_mises":
            values = taken(solution, index, [solution.stress(name, at)])[0, 0, :, 2]
        else:
            number = list(frame.members).index(name)
            rows = solution.section_axes_at(fraction)
            axes = np.broadcast_to(rows, (*solution.shape, *rows.shape[-4:]))[index][0, number]
            parts = across(taken(solution, index, [solution.forces(name, at)])[0, 0], axes)
            values = parts[:, PLACES[what]].squeeze()
    except FrameError:  # of the elements that tell nothing there, either
        return unknown
    return MemberValues(name, fraction, values)


def between_segment_ends(solution: Results, index: Index, values: Array) -> Array:
    """Von Mises stress along members (T, members, k); straight lines where only the ends of segments tell it.

    Parameters
    ----------
    solution
        The solution.
    index
        Index into the batch that leaves one axis.
    values
        The stress as far as it is known along the members.
    """
    there, frame, out = solved(solution, index), solution.frame, values.copy()
    at = np.linspace(0.0, 1.0, values.shape[-1])
    for number, (name, member) in enumerate(frame.members.items()):
        if not np.isnan(values[there, number]).all() or not there.any():
            continue
        ends = np.linspace(0.0, 1.0, member.element.segments + 1)
        try:
            known = taken(solution, index, [solution.stress(name, frame.length(name)[..., None] * ends)])[:, 0, :, 2]
        except FrameError:  # its element tells nothing there, either
            continue
        out[:, number] = [np.interp(at, ends, row) for row in known]
    return out


def untold(found: list[MemberValues], what: str) -> str:
    """Which members tell nothing, in words; empty where all do.

    Parameters
    ----------
    found
        What the members carry.
    what
        What is shown, in words.

    Raises
    ------
    FrameError
        If none of them tells it.
    """
    missing = [each.member for each in found if not each.known]
    if len(missing) == len(found):
        why = "its section is known by its properties only" if "stress" in what else "its element has no section forces"
        raise FrameError(
            f"member {missing[0]!r} does not tell its {what}, nor does any other: {why}; plot 'deformed' in its place"
        )
    return f"; not known of {', '.join(missing[:3])}{' and others' if len(missing) > 3 else ''}" if missing else ""


def add_diagrams(
    scene: Scene,
    solution: Results,
    index: Index,
    rest: Array,
    found: list[MemberValues],
    what: str,
    size: float,
    units: tuple[str, str],
) -> str:
    """Ordinates along the members, bending moments on the side in tension; the greatest of each is told.

    Parameters
    ----------
    scene
        To which they are added.
    solution, index
        Solution, and index of the entry.
    rest
        Undeformed members, (members, k, 3).
    found
        What they carry.
    what
        One of `DIAGRAMS`.
    size
        Size of the frame.
    units
        Units of length and force.

    Returns
    -------
    str
        Title of the figure.
    """
    axes = _axes(solution, index)
    drawn = [_ordinates(what, each.values, own, scene.flat) for each, own in zip(found, axes, strict=True)]
    most = max(float(np.abs(text).max(initial=0.0, where=np.isfinite(text))) for _, text in drawn)
    times, unit = scaled(most, moment_unit(units) if what in ("M", "T") else units[1])
    factor = ORDINATE * size / most if most > 0.0 else 0.0
    for whole, each, (ways, value) in zip(rest, found, drawn, strict=True):
        if not each.known or np.abs(value).max() <= 1e-9 * most:
            continue
        line = whole[0] + each.fraction[:, None] * (whole[-1] - whole[0])
        tips = line + factor * ways
        scene.regions.append(Region(np.concatenate([line, tips[::-1]]), "diagram"))
        scene.strokes.append(Stroke(np.concatenate([line[:1], tips, line[-1:]]), "diagram"))
        scene.strokes.extend(_ordinate_lines(line, tips, every=3 if len(line) == rest.shape[1] else 1))
        for k in _extremes(value):
            scene.labels.append(Label(f"{times * value[k]:.4g}".replace("-", "−"), tips[k], line[k]))
    text = untold(found, DIAGRAMS[what])
    return f"{DIAGRAMS[what]} [{unit}]{', on the side in tension' if what == 'M' else ''}{text}"


def _ordinate_lines(line: Array, tips: Array, every: int) -> Iterator[Stroke]:
    for pair in zip(line[::every], tips[::every], strict=True):
        yield Stroke(np.stack(pair), "ordinate")


def _axes(solution: Results, index: Index) -> Array:
    """Unit vectors along the axes of the members as rows, global, (members, 3, 3)."""
    frame = solution.frame
    rows = []
    for name, member in frame.members.items():
        own = np.asarray(member.element.axes(frame.chord(name)), dtype=float)
        body = frame.nodes[member.start].body
        if body is not None and body == frame.nodes[member.end].body:
            own = own @ np.swapaxes(frame.bodies[body].axes, -1, -2)
        rows.append(own)
    return np.asarray(taken(solution, index, rows)[0])


def _ordinates(what: str, values: Array, axes: Array, flat: tuple[int, int] | None) -> tuple[Array, Array]:
    """Ordinates of a member (k, 3), in the unit of the values, and the values that are told, (k,)."""
    along = axes[None, 0]
    normal = None if flat is None else np.cross(np.eye(3)[flat[0]], np.eye(3)[flat[1]])
    aside = np.broadcast_to(axes[None, 2] if normal is None else np.cross(normal, along), along.shape)
    if what in ("N", "T"):
        return values[..., None] * aside, values
    vectors = values
    if normal is None:
        return (np.cross(along, vectors) if what == "M" else vectors), np.linalg.norm(vectors, axis=-1)
    if what == "V":
        text = np.sum(vectors * aside, axis=-1)
        return text[..., None] * aside, text
    text = vectors @ normal
    return -text[..., None] * aside, text


def _extremes(value: Array) -> list[int]:
    """Stations whose values are told: the greatest, and the least where it is another and not nothing."""
    most = float(np.abs(value).max())
    if np.ptp(value) <= 1e-6 * most:
        return [len(value) // 2]
    found = {int(value.argmax()), int(value.argmin())}
    return sorted(k for k in found if abs(value[k]) > 0.02 * most)
