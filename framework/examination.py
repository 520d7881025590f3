"""Checks of members and masses, done once when they are added to a frame.

Shapes and finite numbers are checked by `linkframe.framework.examined` at every call. Here results are compared with
each other, at two lengths and at a few entries of the batch: matrix, springs and end forces must describe one
stiffness, deformations and axes have the precision of the input, and the displacement along the member that of its
ends.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .batch import Array
from .checked import switch, whole_number
from .dofs import DISPLACEMENTS, FORCES
from .entries import Change, Stretch, flattened
from .errors import FrameError
from .examined import Examined, Unanswered, fits
from .member_law import deformation_rows
from .protocol import LineElement, PointElement

Extended = np.longdouble
_EPS = float(np.finfo(np.float64).eps)
# Share of what is compared by which two answers may differ, and roundings of extended precision.
_ALIKE = 1e-9
_FINE = 32.0
# Lengths at which a member is examined, by its own.
_LENGTHS = (1.0, 1.25)
# Places, as fractions of the length, of the forces by which consistent loads are examined.
_PLACES = np.array([0.25, 0.625])
# Batch entries of which springs are held against those of the batch cut, with as many others before.
_FEW = 2
_LEAST = 64
_FIELDS = 'let metadata {"trailing": k} tell of a field that its last k axes are not of the batch'


def examine_member(name: str, element: LineElement, chord: Array) -> None:
    """Check what a line element returns.

    Parameters
    ----------
    name
        Name of its member.
    element
        The element.
    chord
        From the member's start to its end, (..., 3).

    Raises
    ------
    FrameError
        Where an answer is not what a frame can take.
    """
    own = Examined(element, name)
    _description(own)
    some, along = _few(own, chord)
    transverse = some.axes(along)
    _axes(some, along, transverse)
    length = np.linalg.norm(along, axis=-1)
    _stiffness(some, length)
    _precision(some, along)
    _matrices(some, length)
    if not own.has_springs:
        _rigid(some, length)
    _fields(some, length)
    _loads(some, length)
    if own.has_law:
        _law(some, length)
    _along(some)
    _cut(own, length[:1])
    if own.segments > 1:
        for index in (0, own.segments - 1):
            part = own.part(index, own.segments)
            if isinstance(part, Examined):
                piece, _ = _few(part, chord)
                _stiffness(piece, length / own.segments)


def _description(own: Examined) -> None:
    element, what = own.own, own.what
    if not element.has_springs and type(element).section_flexibility is LineElement.section_flexibility:
        raise FrameError(f"{what} has neither springs nor section_flexibility: give its class one of them")
    shape = element.shape
    if not isinstance(shape, tuple) or not all(isinstance(n, (int, np.integer)) and n >= 0 for n in shape):
        raise FrameError(f"{what}: shape is {shape!r}: give the batch shape, a tuple of whole numbers")
    for number, text in ((element.segments, "segments"), (element.quadrature, "quadrature")):
        whole_number(number, f"{what}: {text}", 1)
    switch(element.exact, f"{what}: exact")
    if not 0.0 <= element.roundings < np.inf:
        raise FrameError(f"{what}: roundings is {element.roundings!r}: give a number from 0 on")
    pairs = element.releases
    known = isinstance(pairs, tuple) and all(
        isinstance(pair, tuple) and len(pair) == 2 and pair[0] in (0, 1) and pair[1] in range(6) for pair in pairs
    )
    if not known:
        raise FrameError(f"{what}: releases is {pairs!r}: give pairs (end, component), end 0 or 1, component 0 to 5")
    try:
        hash(own.kind)
    except TypeError:
        raise FrameError(f"{what}: kind is {element.kind!r}, which cannot be hashed: give a tuple, or self") from None


def _few(own: Examined, chord: Array) -> tuple[Examined, Array]:
    """The element at a few entries, and chords (2, ..., 3) of two lengths there."""
    ndim = max(chord.ndim - 1, len(own.shape))
    along = chord.reshape((1,) * (ndim + 1 - chord.ndim) + chord.shape)
    shape = np.broadcast_shapes(along.shape[:-1], own.shape)
    some = own
    for axis, size in enumerate(shape):
        if size > _FEW:
            change = Stretch(ndim=ndim, axis=axis, indices=slice(0, _FEW))
            some, along = some.cut(change), change(along, 1)
    return some, np.stack([factor * along for factor in _LENGTHS])


def _axes(own: Examined, along: Array, transverse: Array) -> None:
    unit = along / np.linalg.norm(along, axis=-1, keepdims=True)
    off = np.abs(transverse @ np.swapaxes(transverse, -1, -2) - np.eye(3)).max(initial=0.0)
    if off > _ALIKE or np.any(np.linalg.det(transverse) < 0.0):
        raise FrameError(f"{own.what}: axes returned rows that are not right-handed and orthonormal: give rows x, y, z")
    if np.abs(transverse[..., 0, :] - unit).max(initial=0.0) > _ALIKE:
        raise FrameError(f"{own.what}: axes returned an x axis that is not along the member: give it from start to end")


def _stiffness(own: Examined, length: Array) -> None:
    """Check that matrix, springs and end forces agree on one stiffness."""
    matrix, (summed, allowed) = own.stiffness_matrix(length), _summed(*own.springs(length))
    _same(own, "stiffness_matrix", "the sum of its springs, K = sum_i k_i b_i b_i^T", matrix, summed, allowed)
    if not own.has_end_forces:
        return
    unit = np.eye(12).reshape(12, *(1,) * length.ndim, 12)
    forces = np.moveaxis(own.end_forces(length, unit), 0, -1)
    _same(own, "end_forces", "its stiffness times the displacement", forces, summed, allowed)


def _loads(own: Examined, length: Array) -> None:
    """Check that consistent loads do the work of the shape functions, as frames take them."""
    if own.releases or type(own.innermost).consistent_loads is LineElement.consistent_loads:
        return
    x, force = _PLACES.reshape(-1, *(1,) * length.ndim) * length, np.eye(6)
    for k in range(6):
        found = own.consistent_loads(length, x, np.broadcast_to(force[k], (*x.shape, 6)))
        shapes = own.shape_functions(length, x)[..., k, :]
        if np.any(np.abs(found - shapes.sum(axis=0)) > _ALIKE * np.abs(shapes).sum(axis=0)):
            raise FrameError(
                f"{own.what}: consistent_loads of {FORCES[k]} do not do the work of its shape_functions: give the sum "
                "over the places of the shape functions there times the force"
            )


def _summed(k: Array, rows: Array) -> tuple[Array, Array]:
    """Stiffness (..., 12, 12) of springs k (..., n), and by how much another like it may differ, in any units."""
    root = np.sqrt(np.sum(np.abs(k)[..., None] * rows**2, axis=-2))
    return np.swapaxes(rows, -1, -2) @ (k[..., None] * rows), _ALIKE * root[..., :, None] * root[..., None, :]


def _same(own: Examined, method: str, what: str, found: Array, wanted: Array, allowed: Array) -> None:
    off = np.abs(found - wanted)
    if np.any(off > allowed):
        i, j = np.unravel_index(int(np.argmax((off - allowed).reshape(-1, 144).max(axis=0))), (12, 12))
        pair = (np.broadcast_to(each, off.shape)[..., i, j].reshape(-1) for each in (found, wanted))
        here, there = (float(each[int(np.argmax(off[..., i, j]))]) for each in pair)
        raise FrameError(f"{own.what}: {method} is not {what}: entry ({i}, {j}) is {here:.6g} and {there:.6g}")


def _rigid(own: Examined, length: Array) -> None:
    """Check that shape functions contain rigid motions, in which a section law has no strain."""
    stiffness, rows = own.springs(length)
    motions = np.zeros((*length.shape, 12, 6))
    motions[..., :6, :] = motions[..., 6:, :] = np.eye(6)
    motions[..., 7, 5], motions[..., 8, 4] = length, -length
    strain, size = rows @ motions, np.abs(rows) @ np.abs(motions)
    strained = (np.abs(strain) > _ALIKE * size) & (stiffness != 0.0)[..., None]
    if strained.any():
        k = int(np.argwhere(strained)[0][-1])
        raise FrameError(
            f"{own.what}: shape_functions strain in a rigid motion ({DISPLACEMENTS[k]}): give ones by which a "
            "member that moves as a whole stays as it is, such as straight_shapes or cubic_shapes"
        )


def _precision(own: Examined, along: Array) -> None:
    """Check that deformations and axes are computed in the precision of the given length or chord."""
    if np.finfo(Extended).eps > 0.1 * _EPS:
        return
    fine = _FINE * float(np.finfo(Extended).eps)
    chord = along.astype(Extended) * (1.0 + Extended(_EPS) / 16.0)
    length = np.sqrt(np.sum(chord * chord, axis=-1))
    transverse: NDArray[Any] = own.axes(chord)  # type: ignore[arg-type]
    unit = chord / length[..., None]
    off = max(
        np.abs(transverse[..., 0, :] - unit).max(),
        np.abs(transverse @ np.swapaxes(transverse, -1, -2) - np.eye(3)).max(),
    )
    advice = "compute in the dtype of what is given, such as np.result_type(length, np.float64)"
    if off > fine:
        raise FrameError(f"{own.what}: axes are off by {float(off):.1g} for a chord in extended precision: {advice}")
    rounded = own.springs(length.astype(np.float64))[1]
    if np.all(own.springs(length)[1] == rounded) and np.any(own.springs(2.0 * length)[1] != rounded):
        raise FrameError(f"{own.what}: springs rounds its deformations for a length in extended precision: {advice}")


def _matrices(own: Examined, length: Array) -> None:
    with suppress(Unanswered):
        _symmetric(own, "mass_matrix", own.mass_matrix(length))
    try:
        once = own.geometric_matrix(length, np.ones(()))
        twice = own.geometric_matrix(length, np.full(length.shape, 2.0))
    except Unanswered:
        return
    _symmetric(own, "geometric_matrix", once)
    if np.abs(twice - 2.0 * once).max(initial=0.0) > _ALIKE * np.abs(once).max(initial=0.0):
        raise FrameError(f"{own.what}: geometric_matrix is not proportional to the axial force")


def _symmetric(own: Examined, method: str, matrix: Array) -> None:
    if np.abs(matrix - np.swapaxes(matrix, -1, -2)).max(initial=0.0) > _ALIKE * np.abs(matrix).max(initial=0.0):
        raise FrameError(f"{own.what}: {method} returned a matrix that is not symmetric")


def _fields(own: Examined, length: Array) -> None:
    """Check what the element returns between its ends."""
    fraction = np.full(length.shape, 0.25)
    asked = (own.section_flexibility, own.mass_per_length, own.section_inertia, own.free_strain, own.restrained_forces)
    for ask in asked:
        with suppress(Unanswered):
            ask(fraction)
    try:
        own.stress(fraction, np.zeros((*length.shape, 6)))
    except Unanswered:
        pass
    except FrameError as error:
        if str(error).startswith(own.what):
            raise
    try:
        ends = [own.shape_functions(length, x) for x in (0.0 * length, length)]
    except Unanswered:
        return
    if own.releases:
        return
    for side, found in enumerate(ends):
        wanted = np.eye(12)[6 * side : 6 * side + 3]
        size = np.maximum(1.0, length)[..., None, None]
        if np.any(np.abs(found[..., :3, :] - wanted) > _ALIKE * size):
            where = ("start", "end")[side]
            raise FrameError(f"{own.what}: shape_functions at the {where} do not give the displacement of that node")


def _law(own: Examined, length: Array) -> None:
    """Check that the tangent of an element's nonlinear law at zero deformation is its stiffness."""
    stiffness = own.stiffness_matrix(length)
    shape = np.broadcast_shapes(length.shape, own.shape, stiffness.shape[:-2])
    whole = np.broadcast_to(length, shape).reshape(-1)

    def pick(array: Array, trailing: int) -> Array:
        return flattened(array, shape, trailing)

    _, force, tangent = own.resistance(whole, np.zeros((len(whole), 7)), pick)
    rows = deformation_rows(whole)
    found = np.swapaxes(rows, -1, -2) @ tangent @ rows
    wanted = np.broadcast_to(stiffness, (*shape, 12, 12)).reshape(-1, 12, 12)
    size = np.abs(wanted).max(initial=0.0)
    if np.any(force) or np.any(np.abs(found - wanted) > _ALIKE * size * np.maximum(1.0, whole.max(initial=0.0)) ** 2):
        raise FrameError(
            f"{own.what}: resistance is not its stiffness at rest, which linear solutions follow: let it return no "
            "force without deformation, and the tangent that springs and stiffness_matrix have"
        )


def _along(own: Examined) -> None:
    """Check that the parts of a member agree with the whole if they are given as the whole."""
    if own.segments == 1 or (own.part(0, 2) is not own and getattr(own.part(0, 2), "own", None) is not own.own):
        return
    for method in ("section_flexibility", "section_inertia", "free_strain"):
        here, there = (getattr(own, method)(np.array([fraction])) for fraction in (0.25, 0.75))
        if here is not None and np.any(here != there):
            raise FrameError(
                f"{own.what}: {method} varies along the member, and part returns the whole: give its class a method "
                "part(index, count), or one segment"
            )


def _cut(own: Examined, length: Array) -> None:
    """Check that the element at some entries of the batch agrees with that of the whole batch."""
    shape = own.shape
    for axis, size in enumerate(shape):
        if size <= _FEW:
            continue
        last = {n: Stretch(ndim=len(shape), axis=axis, indices=slice(-n, None)) for n in (_FEW, _LEAST)}
        few, more = (own if n >= size else own.cut(_within(own, part)) for n, part in last.items())
        at = np.full((1,) * (len(shape) + 1), float(length.reshape(-1)[0]))
        here, there = few.springs(at), [last[_FEW](each, k) for each, k in zip(more.springs(at), (1, 2), strict=True)]
        if any(one.shape != other.shape for one, other in zip(here, there, strict=True)):
            raise FrameError(f"{own.what}: cut to a few entries of its batch it returns other springs: {_FIELDS}")
        # to rounding: what is summed up, as along a taper, may differ in the last bit where less is summed at once
        text = "the sum of its springs, cut to a few entries of its batch,"
        _same(own, text, f"that of the whole batch there ({_FIELDS})", _summed(*here)[0], *_summed(*there))


def _within(own: Examined, change: Change) -> Change:
    """`change`, with an error for arrays that do not have the batch shape."""

    def checked(array: Array, trailing: int) -> Array:
        lead = array.shape[: array.ndim - trailing]
        if not fits(lead, own.shape):
            raise FrameError(
                f"{own.what}: cut takes an array of shape {array.shape} for one of the batch {own.shape}: {_FIELDS}"
            )
        return change(array, trailing)

    return checked


def examine_mass(name: str, element: PointElement) -> None:
    """Check what a point mass returns.

    Raises
    ------
    FrameError
        Where its mass matrix is not one.
    """
    what = f"{type(element).__name__} of mass {name!r}"
    matrix = np.asarray(element.mass_matrix())
    lead = matrix.shape[:-2]
    if matrix.dtype.kind not in "fiu" or matrix.shape[-2:] != (6, 6) or not np.isfinite(matrix).all():
        raise FrameError(f"{what}: mass_matrix returned shape {matrix.shape}: give finite numbers (..., 6, 6)")
    if not fits(lead, element.shape):
        raise FrameError(f"{what}: mass_matrix has batch axes {lead}, which its shape {element.shape} leaves out")
    if np.abs(matrix - np.swapaxes(matrix, -1, -2)).max(initial=0.0) > _ALIKE * np.abs(matrix).max(initial=0.0):
        raise FrameError(f"{what}: mass_matrix returned a matrix that is not symmetric")
