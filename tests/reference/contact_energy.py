"""Planar frames with clearance by energy alone: dense textbook beams, the joints' law, and scipy's minimiser."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import minimize

Array = np.ndarray[Any, np.dtype[Any]]


@dataclass
class PlanarFrame:
    """Nodes with ``ux uy rz``; beams, pins with clearance, supports and loads are added to an energy.

    Π(u) = ½ u·K u − p·u + Σ k/2 max(|u_b − u_a| − ε, 0)²
    """

    places: list[tuple[float, float]]
    stiffness: Array = field(init=False)
    load: Array = field(init=False)
    pins: list[tuple[int, int, float, float]] = field(default_factory=list)
    held: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        size = 3 * len(self.places)
        self.stiffness, self.load = np.zeros((size, size)), np.zeros(size)

    def beam(self, a: int, b: int, EA: float, EI: float) -> None:
        (x1, y1), (x2, y2) = self.places[a], self.places[b]
        length = np.hypot(x2 - x1, y2 - y1)
        c, s = (x2 - x1) / length, (y2 - y1) / length
        # strain, end rotations from the chord: three deformations of six displacements
        chord = np.array([s, -c, 0.0, -s, c, 0.0]) / length
        rows = np.array([[-c, -s, 0.0, c, s, 0.0], -chord, -chord])
        rows[1, 2] += 1.0
        rows[2, 5] += 1.0
        bending = EI / length * np.array([[4.0, 2.0], [2.0, 4.0]])
        own = rows[:1].T @ rows[:1] * EA / length + rows[1:].T @ bending @ rows[1:]
        dofs = [3 * a, 3 * a + 1, 3 * a + 2, 3 * b, 3 * b + 1, 3 * b + 2]
        self.stiffness[np.ix_(dofs, dofs)] += own

    def minimum(self) -> Array:
        """Displacements of all nodes at the least energy, (nodes, 3)."""
        free = np.array([k for k in range(len(self.load)) if k not in self.held])
        # displacements in units of the largest clearance, energies in units of what a pin stores at it
        length = max([eps for *_, eps in self.pins] + [1e-6])
        unit = max(np.abs(self.load).max() * length, 1e-30)

        def whole(x: Array) -> Array:
            u = np.zeros(len(self.load))
            u[free] = length * x
            return u

        def terms(x: Array) -> tuple[float, Array, Array]:
            u = whole(x)
            energy = 0.5 * u @ self.stiffness @ u - self.load @ u
            slope, curve = self.stiffness @ u - self.load, self.stiffness.copy()
            for a, b, k, eps in self.pins:
                rows = np.zeros((2, len(u)))
                rows[[0, 1], [3 * b, 3 * b + 1]], rows[[0, 1], [3 * a, 3 * a + 1]] = 1.0, -1.0
                gap = rows @ u
                r = np.hypot(*gap)
                if r > eps:
                    n = gap / r
                    energy += 0.5 * k * (r - eps) ** 2
                    slope += k * (r - eps) * n @ rows
                    across = np.eye(2) - np.outer(n, n)
                    curve += rows.T @ (k * np.outer(n, n) + k * (r - eps) / r * across) @ rows
            scaled = curve[np.ix_(free, free)] * length**2 / unit
            return energy / unit, slope[free] * length / unit, scaled

        found = minimize(
            lambda x: terms(x)[0],
            np.zeros(len(free)),
            jac=lambda x: terms(x)[1],
            hess=lambda x: terms(x)[2],
            method="trust-exact",
            options={"gtol": 1e-9, "maxiter": 5000, "max_trust_radius": 1e6},
        )
        x = found.x
        for _ in range(3):  # to the last digits, on the pieces on which the energy is smooth
            _, slope, curve = terms(x)
            x = x - np.linalg.lstsq(curve, slope, rcond=1e-14)[0]
        return whole(x).reshape(-1, 3)
