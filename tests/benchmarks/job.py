"""The paper's job as numbers: a four-bar at many poses, with samples of joint stiffness, clearance and load.

Everybody solves the same `Job`: linkframe, the peers and, at chosen entries, the reference in 50 digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from linkframe.models import FourBar
from numpy.typing import NDArray
from reference.four_bar import IY, IZ, JOINTS, LENGTH, NU, A, E, J, four_bar
from reference.stiffness_method import mp
from reference.structure import LOADS, Spring, Structure, Vector

from .fifty_digits import displacements

Array = NDArray[np.float64]

BAR = Section(A=A, Iy=IY, Iz=IZ, J=J)
STEEL = Material(E=E, nu=NU, density=7850.0)
NODES = ("A", "B.crank", "B.coupler", "P", "D.coupler", "D.rocker", "E.rocker", "E")
PLANE = (0, 1, 5)


@dataclass(frozen=True)
class Job:
    """Poses times samples of the symmetric four-bar.

    Attributes
    ----------
    theta
        Crank angles, radians, (poses,).
    stiffness
        By joint: ``ktx kty ktz krx kry krz``, (samples, 6).
    offset
        By joint: clearance ``ux uy``, (samples, 2).
    load
        ``fx fy fz mx my mz`` on P, (samples, 6).
    """

    theta: Array
    stiffness: dict[str, Array]
    offset: dict[str, Array]
    load: Array

    @property
    def shape(self) -> tuple[int, int]:
        """Poses and samples."""
        return len(self.theta), len(self.load)

    @property
    def size(self) -> int:
        """Number of entries."""
        return len(self.theta) * len(self.load)

    def part(self, poses: Sequence[int] | slice, samples: int) -> Job:
        """Some poses and the first samples."""
        stiffness = {name: value[:samples] for name, value in self.stiffness.items()}
        offset = {name: value[:samples] for name, value in self.offset.items()}
        return replace(self, theta=self.theta[poses], stiffness=stiffness, offset=offset, load=self.load[:samples])

    def frame(self, segments: int = 1) -> Frame:
        """The job as it is put to linkframe: described in space."""
        beam = Beam(BAR, STEEL, segments=segments)
        frame = FourBar(beam=beam, stiffness=self.stiffness).move(self.theta[:, None]).frame()
        for joint, gap in self.offset.items():
            frame.offset(joint, ux=gap[:, 0], uy=gap[:, 1])
        frame.load("P", **{name: f for name, f in zip(LOADS, self.load.T, strict=True) if np.any(f)})
        return frame

    def coordinates(self) -> dict[str, Array]:
        """Global coordinates of the nodes, (poses, 3)."""
        crank = LENGTH * np.stack([np.cos(self.theta), np.sin(self.theta), np.zeros(len(self.theta))], axis=-1)
        along, ground = {"B": 0.0, "P": LENGTH, "D": 2.0 * LENGTH}, {"A": 0.0, "E": 2.0 * LENGTH}
        places = {name: crank + np.array([x, 0.0, 0.0]) for name, x in along.items()}
        places |= {name: np.broadcast_to((x, 0.0, 0.0), crank.shape) for name, x in ground.items()}
        return {node: places[node.split(".")[0]] for node in NODES}

    def pushes(self) -> dict[str, Array]:
        """Loads on nodes, (samples, 6): the load on P, and stiffness times clearance on both sides of the joints."""
        loads = {"P": self.load}
        for joint, (first, second) in JOINTS.items():
            push = np.zeros_like(self.load)
            push[:, :2] = self.stiffness[joint][:, :2] * self.offset[joint]
            loads |= {first: -push, second: push}
        return loads

    def truth(self, pose: int, sample: int) -> Array:
        """Displacement of P, (6,), of the ideal linkage at the float angle, by 50 digits."""
        theta, length, zero = mp.mpf(float(self.theta[pose])), mp.mpf(LENGTH), mp.mpf(0)
        x, y = length * mp.cos(theta), length * mp.sin(theta)
        b, p, d = ((x + k * length, y, zero) for k in range(3))
        places: dict[str, Vector] = {"A": (zero,) * 3, "B": b, "P": p, "D": d, "E": (2 * length, zero, zero)}
        structure = four_bar({node: places[node.split(".")[0]] for node in NODES}, tuple(self.load[sample]))
        loads: dict[str, tuple[object, ...]] = dict(structure.loads)
        joints = {}
        for joint, (first, second) in JOINTS.items():
            k, gap = self.stiffness[joint][sample], self.offset[joint][sample]
            push = [mp.mpf(float(k[i])) * mp.mpf(float(gap[i])) for i in range(2)]
            loads[first], loads[second] = (-push[0], -push[1], *(0,) * 4), (*push, *(0,) * 4)
            joints[joint] = Spring(first, second, tuple(map(float, k)))
        return displacements(Structure(structure.nodes, structure.members, joints, (), structure.supports, loads))["P"]


def job(poses: int, samples: int, *, space: bool, seed: int = 0) -> Job:
    """The job over the full turn: five springs of each joint, two components of its clearance, and the load vary."""
    rng = np.random.default_rng(seed)
    # A quarter of a step off, since 0 and 180 degrees are singular.
    theta = 2.0 * np.pi * (np.arange(poses) + 0.25) / poses
    stiffness = {joint: 2e11 * np.exp(0.1 * rng.normal(size=(samples, 6))) for joint in JOINTS}
    for each in stiffness.values():
        each[:, 5] = 0.0
    offset = {joint: 1e-4 * rng.normal(size=(samples, 2)) for joint in JOINTS}
    load = rng.normal((10.0, 100.0, 30.0, 1.0, 2.0, 0.5), (1.0, 5.0, 3.0, 0.1, 0.2, 0.05), size=(samples, 6))
    if not space:
        load[:, 2:5] = 0.0
    return Job(theta, stiffness, offset, load)


def error(found: Array, truth: Array) -> Array:
    """Relative error (...) of displacements (..., 6): lengths and angles each against their greatest, the worse."""
    worst = []
    for part in (slice(0, 3), slice(3, 6)):
        size = np.abs(truth[..., part]).max(axis=-1)
        worst.append(np.abs(found[..., part] - truth[..., part]).max(axis=-1) / size)
    greatest: Array = np.maximum(*worst)
    return greatest
