"""Natural frequencies and mode shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import dense
from .batch import Array
from .errors import FrameError
from .frame import Frame
from .plan import Plan
from .spectrum import inverse_pencil

# Rigid-body and mechanism modes: the stiffness is shifted by this share of a typical squared frequency.
_SHIFT = 1e-6
_REGULAR = 1e-12


@dataclass(frozen=True)
class Modes:
    """Natural modes of a frame, the slowest first.

    Attributes
    ----------
    frequencies
        Hz, (..., count).
    """

    frequencies: Array
    _plan: Plan
    _vectors: Array

    def shapes(self, node: str) -> Array:
        """Displacement of a node in each mode, (..., count, 6), global; modes have unit modal mass."""
        number = self._plan.topology.number[node]
        moved = dense.global_substitution(self._plan, [number]) @ self._vectors
        return np.swapaxes(moved, -1, -2)


def modes(frame: Frame, count: int) -> Modes:
    """The `count` lowest modes of ``K x = omega^2 M x`` for every batch entry.

    Raises
    ------
    FrameError
        Where the frame has no mass, or fewer modes than asked for.
    """
    plan = Plan(frame.copy())
    stiffness, mass = dense.stiffness(plan), dense.mass(plan)
    if not 1 <= count <= stiffness.shape[-1]:
        raise FrameError(f"modes({count}): give a number from 1 to the frame's {stiffness.shape[-1]} unknowns")
    if not np.any(mass):
        raise FrameError("modes: the frame has no mass: give its materials a density, or add a PointMass")
    shift = _shift(stiffness, mass)
    values, vectors = inverse_pencil(stiffness + shift[..., None, None] * mass, mass, count)
    if np.any(values <= 0.0):
        raise FrameError(f"modes({count}): only {int((values > 0).sum(axis=-1).min())} modes have mass: ask for fewer")
    squared = np.maximum(1.0 / values - shift[..., None], 0.0)
    frequencies = np.sqrt(squared) / (2.0 * np.pi)
    shape = np.broadcast_shapes(frame.shape, frequencies.shape[:-1])
    return Modes(np.array(np.broadcast_to(frequencies, (*shape, count))), plan, vectors / np.sqrt(values)[..., None, :])


def _shift(stiffness: Array, mass: Array) -> Array:
    """Zero where the stiffness is regular, else a small share of the frame's typical squared frequency."""
    shape = np.broadcast_shapes(stiffness.shape[:-2], mass.shape[:-2])
    least = np.linalg.eigvalsh(dense.scaled(stiffness)[0])[..., 0]
    trace = np.trace(stiffness, axis1=-2, axis2=-1) / np.trace(mass, axis1=-2, axis2=-1)
    first = np.broadcast_to(np.where(least > _REGULAR, 0.0, _SHIFT * trace), shape)
    return np.array(first)
