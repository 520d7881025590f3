"""NumPy's way: the textbook matrices of all samples in one stack, for `numpy.linalg.solve`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from reference.four_bar import ENDS, IY, IZ, JOINTS, A, E, G, J

from .job import NODES, PLANE, Job

Array = NDArray[np.float64]
FREE = NODES[1:-1]


class Stacked:
    """The job's matrices, joints as springs between nodes that coincide.

    Parameters
    ----------
    job
        The job.
    plane
        Only the unknowns in the plane, 18 instead of 36.
    """

    def __init__(self, job: Job, *, plane: bool = False) -> None:
        self.job = job
        components = PLANE if plane else tuple(range(6))
        dofs = [6 * node + k for node in range(len(FREE)) for k in components]
        self.beams = _beams(job)[:, dofs][:, :, dofs]
        self.at = {node: np.array([dofs.index(6 * n + k) for k in components]) for n, node in enumerate(FREE)}
        self.components = list(components)

    def loads(self) -> Array:
        """Right-hand sides, (samples, n, 1)."""
        f = np.zeros((len(self.job.load), self.beams.shape[-1], 1))
        for node, push in self.job.pushes().items():
            if node in self.at:
                f[:, self.at[node], 0] += push[:, self.components]
        return f

    def matrices(self, pose: int) -> Array:
        """Stiffness matrices of a pose, (samples, n, n)."""
        matrix = np.repeat(self.beams[pose : pose + 1], len(self.job.load), axis=0)
        for joint, (first, second) in JOINTS.items():
            k, i = self.job.stiffness[joint][:, self.components], self.at[first]
            matrix[:, i, i] += k
            if second in self.at:
                j = self.at[second]
                matrix[:, j, j] += k
                matrix[:, i, j] -= k
                matrix[:, j, i] -= k
        return matrix

    def solve(self) -> Array:
        """Assemble and solve: displacement of P, (poses, samples, 6)."""
        loads = self.loads()
        return self.displacement([np.linalg.solve(self.matrices(pose), loads) for pose in range(len(self.job.theta))])

    def displacement(self, solved: list[Array]) -> Array:
        """Displacement of P from the solutions of each pose."""
        found = np.zeros((*self.job.shape, 6))
        for pose, u in enumerate(solved):
            found[pose][:, self.components] = u[:, self.at["P"], 0]
        return found


def _beams(job: Job) -> Array:
    """Stiffness of the four bars at the free nodes, (poses, 36, 36)."""
    places = job.coordinates()
    whole = np.zeros((len(job.theta), 6 * len(NODES), 6 * len(NODES)))
    for start, end in ENDS.values():
        dofs = np.concatenate([6 * NODES.index(node) + np.arange(6) for node in (start, end)])
        whole[:, dofs[:, None], dofs] += beam(places[end] - places[start])
    return whole[:, 6:-6, 6:-6]


def beam(chord: Array, E: Array | float = E, G: Array | float = G) -> Array:
    """Stiffness of the bar along a chord in the plane, (..., 12, 12), global."""
    length = np.linalg.norm(chord, axis=-1)
    c, s = chord[..., 0] / length, chord[..., 1] / length
    local = np.zeros((*length.shape, 12, 12))
    for i, k in ((0, E * A), (3, G * J)):
        local[..., i, i] = local[..., i + 6, i + 6] = k / length
        local[..., i, i + 6] = local[..., i + 6, i] = -k / length
    for v, r, sign, inertia in ((1, 5, 1.0, IZ), (2, 4, -1.0, IY)):
        dofs = np.array([v, r, v + 6, r + 6])
        a, b, near, far = 12 / length**2, 6 * sign / length, 4 + 0 * length, 2 + 0 * length
        rows = [[a, b, -a, b], [b, near, -b, far], [-a, -b, a, -b], [b, far, -b, near]]
        bending = np.moveaxis(np.array(rows), (0, 1), (-2, -1))
        local[..., dofs[:, None], dofs] = (E * inertia / length)[..., None, None] * bending
    turn = np.zeros_like(local)
    for at in range(0, 12, 3):
        turn[..., at, at], turn[..., at, at + 1] = c, s
        turn[..., at + 1, at], turn[..., at + 1, at + 1] = -s, c
        turn[..., at + 2, at + 2] = 1.0
    stiffness: Array = np.swapaxes(turn, -1, -2) @ local @ turn
    return stiffness
