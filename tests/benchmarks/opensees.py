"""OpenSees, by openseespy: a model built anew for every entry, or once a pose with its parameters updated in place."""

from __future__ import annotations

import os

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray
from reference.four_bar import ENDS, IY, IZ, JOINTS, A, E, G, J

from .job import NODES, PLANE, Job

Array = NDArray[np.float64]
TAG = {node: k for k, node in enumerate(NODES, start=1)}
P = TAG["P"]
FIRST_JOINT = 11


class Opensees:
    """The job for openseespy.

    Parameters
    ----------
    job
        The job.
    plane
        A model of three components a node instead of six.
    """

    def __init__(self, job: Job, *, plane: bool = False) -> None:
        self.job, self.plane = job, plane
        self.components = list(PLANE if plane else range(6))
        self.coordinates = {node: np.asarray(place).tolist() for node, place in job.coordinates().items()}
        self.springs = [k for k in range(len(self.components)) if self.components[k] != 5]
        columns = [self.components[k] for k in self.springs]
        self.stiffness = np.concatenate([job.stiffness[joint][:, columns] for joint in JOINTS], axis=1).tolist()
        pushes = {n: f[:, self.components] for n, f in job.pushes().items() if n != "E"}
        self.loads = [[(TAG[node], push[s].tolist()) for node, push in pushes.items()] for s in range(len(job.load))]

    def rebuilt(self) -> Array:
        """Every entry a model of its own: displacement of P, (poses, samples, 6)."""
        found = np.zeros((*self.job.shape, 6))
        for pose, sample in np.ndindex(*self.job.shape):
            self._build(pose, sample)
            self._push(sample)
            self._analyse()
            found[pose, sample, self.components] = ops.nodeDisp(P)
        ops.wipe()
        return found

    def updated(self) -> Array:
        """A model a pose, its springs and loads updated for every sample: displacement of P, (poses, samples, 6)."""
        found = np.zeros((*self.job.shape, 6))
        for pose in range(len(self.job.theta)):
            self._build(pose, 0)
            self._parameters()
            self._push(0)
            self._analyse()
            for sample, stiffness in enumerate(self.stiffness):
                for tag, value in enumerate(stiffness, start=1):
                    ops.updateParameter(tag, value)
                ops.remove("loadPattern", 1)
                ops.pattern("Plain", 1, 1)
                for node, push in self.loads[sample]:
                    ops.load(node, *push)
                # Without it the rounding of all samples before adds up.
                ops.reset()
                _solve()
                found[pose, sample, self.components] = ops.nodeDisp(P)
        ops.wipe()
        return found

    def _build(self, pose: int, sample: int) -> None:
        ops.wipe()
        ops.logFile(os.devnull, "-noEcho")
        ops.model("basic", "-ndm", 2 if self.plane else 3, "-ndf", len(self.components))
        for node, places in self.coordinates.items():
            ops.node(TAG[node], *places[pose][: 2 if self.plane else 3])
        for node in ("A", "E"):
            ops.fix(TAG[node], *(1,) * len(self.components))
        if self.plane:
            ops.geomTransf("Linear", 1)
        else:
            ops.geomTransf("Linear", 1, 0.0, 0.0, 1.0)
        section = (A, E, IZ) if self.plane else (A, E, G, J, IY, IZ)
        for tag, (start, end) in enumerate(ENDS.values(), start=1):
            ops.element("elasticBeamColumn", tag, TAG[start], TAG[end], *section, 1)
        tag = 0
        for number, (first, second) in enumerate(JOINTS.values(), start=FIRST_JOINT):
            materials = range(tag + 1, tag + 1 + len(self.springs))
            for tag in materials:
                ops.uniaxialMaterial("Elastic", tag, self.stiffness[sample][tag - 1])
            directions = [k + 1 for k in self.springs]
            ops.element("zeroLength", number, TAG[first], TAG[second], "-mat", *materials, "-dir", *directions)

    def _push(self, sample: int) -> None:
        ops.timeSeries("Constant", 1)
        ops.pattern("Plain", 1, 1)
        for node, push in self.loads[sample]:
            ops.load(node, *push)

    def _parameters(self) -> None:
        """Make every spring a parameter, numbered joint by joint."""
        tag = 0
        for number in range(FIRST_JOINT, FIRST_JOINT + len(JOINTS)):
            for spring in range(1, len(self.springs) + 1):
                tag += 1
                ops.parameter(tag, "element", number, "material", spring, "E")

    def _analyse(self) -> None:
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("BandSPD")
        ops.algorithm("Linear")
        ops.integrator("LoadControl", 0.0)
        ops.analysis("Static", "-noWarnings")
        _solve()


def _solve() -> None:
    if ops.analyze(1):
        raise ArithmeticError("openseespy's analyze reports failure")
