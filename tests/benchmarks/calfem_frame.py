"""CALFEM: the bars' matrices once a pose, the joints' and the solution for every entry."""

from __future__ import annotations

import calfem.core as cfc
import numpy as np
from numpy.typing import NDArray
from reference.four_bar import ENDS, IY, IZ, JOINTS, A, E, G, J

from .job import NODES, Job

Array = NDArray[np.float64]
# Degrees of freedom count from 1.
DOFS = {node: 6 * k + 1 + np.arange(6) for k, node in enumerate(NODES)}
HELD = np.concatenate([DOFS["A"], DOFS["E"]])


def solve(job: Job) -> Array:
    """Displacement of P, (poses, samples, 6)."""
    pushes = job.pushes()
    found = np.zeros((*job.shape, 6))
    for pose in range(len(job.theta)):
        bars = _bars(job, pose)
        for sample in range(len(job.load)):
            matrix, load = bars.copy(), np.zeros((6 * len(NODES), 1))
            for joint, (first, second) in JOINTS.items():
                k = np.diag(job.stiffness[joint][sample])
                cfc.assem(np.concatenate([DOFS[first], DOFS[second]]), matrix, np.block([[k, -k], [-k, k]]))
            for node, push in pushes.items():
                load[DOFS[node] - 1, 0] += push[sample]
            found[pose, sample] = cfc.solveq(matrix, load, HELD)[0][DOFS["P"] - 1, 0]
    return found


def _bars(job: Job, pose: int) -> Array:
    places = job.coordinates()
    matrix = np.zeros((6 * len(NODES), 6 * len(NODES)))
    for start, end in ENDS.values():
        ends = np.stack([places[start][pose], places[end][pose]], axis=-1)
        bar = cfc.beam3e(*ends, np.array([0.0, 0.0, 1.0]), [E, G, A, IY, IZ, J])
        cfc.assem(np.concatenate([DOFS[start], DOFS[end]]), matrix, bar)
    return matrix
