"""PyNite: a model a pose, updated in place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from Pynite import FEModel3D
from Pynite.PhysMember import PhysMember
from Pynite.Spring3D import Spring3D
from reference.four_bar import ENDS, IY, IZ, JOINTS, A, E, G, J

from .job import NODES, Job

Array = NDArray[np.float64]
COMPONENTS = ("DX", "DY", "DZ", "RX", "RY", "RZ")
LOADS = ("FX", "FY", "FZ", "MX", "MY", "MZ")


class SixSprings(Spring3D):
    """Six springs between coincident nodes, in global axes; PyNite's own has one, along the line between its nodes."""

    def ke(self) -> Array:
        """Stiffness, (12, 12)."""
        k = np.diag(self.ks)
        return np.block([[k, -k], [-k, k]])

    def T(self) -> Array:
        """From global to local axes, (12, 12)."""
        return np.eye(12)


class Bar(PhysMember):
    """A member in one piece; PyNite's own is cut at nodes on its line, and takes the twin node of a joint for one."""

    def descritize(self) -> None:
        """Make its only part."""
        nodes = self.model.nodes
        self.model.nodes = {node.name: node for node in (self.i_node, self.j_node)}
        super().descritize()
        self.model.nodes = nodes


def solve(job: Job) -> Array:
    """A model a pose, its springs and loads changed for every sample: displacement of P, (poses, samples, 6)."""
    pushes = {node: push for node, push in job.pushes().items() if node != "E"}
    found = np.zeros((*job.shape, 6))
    for pose in range(len(job.theta)):
        model = _model(job, pose)
        for sample in range(len(job.load)):
            for joint in JOINTS:
                model.springs[joint].ks = job.stiffness[joint][sample]
            for node, push in pushes.items():
                model.nodes[node].NodeLoads.clear()
                for direction, value in zip(LOADS, push[sample], strict=True):
                    if value:
                        model.add_node_load(node, direction, value)
            model.analyze_linear(check_stability=False, sparse=False)
            found[pose, sample] = [getattr(model.nodes["P"], name)["Combo 1"] for name in COMPONENTS]
    return found


def _model(job: Job, pose: int) -> FEModel3D:
    places = job.coordinates()
    model = FEModel3D()
    model.add_material("steel", E, G, 0.3, 7850.0)
    model.add_section("bar", A, IY, IZ, J)
    for node in NODES:
        model.add_node(node, *places[node][pose])
    for node in ("A", "E"):
        model.def_support(node, *(True,) * 6)
    for name, (start, end) in ENDS.items():
        model.members[name] = Bar(model, name, model.nodes[start], model.nodes[end], "steel", "bar")
    for joint, (first, second) in JOINTS.items():
        pair = model.nodes[first], model.nodes[second]
        model.springs[joint] = SixSprings(joint, *pair, job.stiffness[joint][0], model.load_combos)
    return model
