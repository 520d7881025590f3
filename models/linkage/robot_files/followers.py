"""Joints that move in proportion to a drive, which replace the loops of a linkage in formats without loops."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..poses.coordinates import coordinate_of
from ..poses.kinematics import Kinematics
from .body_tree import BodyTree, TreeStep, advance_of

# Number of sampled poses, and largest deviation of a coordinate from proportion, in radians or sizes of the linkage.
POSES, STRAIGHT = 101, 1e-9
REMEDY = "write MJCF (.xml), which holds them"
# Relative difference from a simple ratio that counts as rounding.
ROUNDED = 1e-12
# Range of several drives in the sampled poses, in half turns and sizes of the linkage; and least number of assembled
# poses.
FAR, FEWEST = 0.1, 10


@dataclass(frozen=True)
class Follower:
    """A motion that is ``factor`` times that of the step `leader`, both counted from the reference configuration.

    A factor of 0 means that it is at rest.
    """

    leader: str
    factor: float


def followers(tree: BodyTree, format_name: str) -> dict[str, Follower]:
    """By name of a step: what it follows. The advance of a screw follows its angle, and in loops all steps the drives.

    Raises
    ------
    FrameError
        If the linkage has a loop in which a joint does not move in proportion to a drive.
    """
    out = {
        f"{body.joint.name} uz": Follower(f"{body.joint.name} rz", advance_of(body.joint))
        for body in tree.bodies
        if body.joint.kind.name == "screw"
    }
    if not tree.closures:
        return out
    loops = ", ".join(closure.name for closure in tree.closures)
    closing = {body.joint.name for body in tree.bodies if body.part_of is not None}
    if not tree.linkage.drives or closing & tree.linkage.drives.keys():
        raise FrameError(f"{format_name} has no closed loops, and joint {loops} closes one: {REMEDY}")
    drives, coordinates = _sampled(tree)
    for step in tree.steps.values():
        if step.name in out or step.name in drives or step.joint in closing:
            continue
        found = _followed(step, drives, coordinates, 1.0 if step.is_rotation else tree.placed.size)
        if isinstance(found, str):
            raise FrameError(f"{format_name} has no closed loops ({loops} closes one), and {found}: {REMEDY}")
        out[step.name] = found
    return out


def _sampled(tree: BodyTree) -> tuple[dict[str, Array], dict[tuple[str, str], Array]]:
    """Coordinates of driven steps by name, and of all joints by component, from the reference ones on, (poses,)."""
    linkage = tree.linkage
    motion = Kinematics.of(linkage, _values(tree), {}, {})
    if motion.is_assembled.sum() < FEWEST:
        raise FrameError("the linkage cannot be assembled beside its reference configuration: choose another one")
    coordinates: dict[tuple[str, str], Array] = {}
    for name, pair in linkage.joints.items():
        moved = (coordinate_of(motion, pair) - tree.placed.coordinates(pair))[motion.is_assembled]
        coordinates |= {(name, each): moved[:, k] for k, each in enumerate(pair.kind.coordinates)}
    named = {(step.joint, step.component): name for name, step in tree.steps.items()}
    driven = [(joint, each) for joint, those in linkage.drives.items() for each in those]
    return {named[own]: coordinates[own] for own in driven if own in named}, coordinates


def _values(tree: BodyTree) -> dict[str, Array]:
    """Values of the drives about the reference configuration: over the whole range of one drive, random for several."""
    driven = [(name, coordinate) for name, those in tree.linkage.drives.items() for coordinate in those]
    away = np.linspace(-1.0, 1.0, POSES)[:, None]
    if len(driven) > 1:
        away = np.random.default_rng(0).uniform(-FAR, FAR, (POSES, len(driven)))
    out: dict[str, list[Array]] = {}
    for (name, coordinate), moved in zip(driven, away.T, strict=True):
        pair = tree.linkage.joints[name]
        start = tree.placed.coordinates(pair)[pair.kind.coordinates.index(coordinate)]
        out.setdefault(name, []).append(start + moved * (np.pi if coordinate[0] == "r" else tree.placed.size))
    return {name: np.stack(own, axis=-1) if len(own) > 1 else own[0] for name, own in out.items()}


def _followed(
    step: TreeStep, drives: dict[str, Array], coordinates: dict[tuple[str, str], Array], unit: float
) -> Follower | str:
    """What a step follows; a text that says why if it follows nothing in proportion."""
    if step.component == "ball":
        turned = max(float(np.abs(coordinates[step.joint, each]).max()) for each in ("rx", "ry", "rz"))
        return Follower("", 0.0) if turned < STRAIGHT else f"ball {step.joint!r} turns"
    moved = coordinates[step.joint, step.component]
    table = np.stack(list(drives.values()), axis=-1)
    factors, *_ = np.linalg.lstsq(table, moved, rcond=None)
    off = float(np.abs(table @ factors - moved).max())
    if off > STRAIGHT * unit:
        return f"joint {step.name!r} does not follow the drive in proportion (it is off by up to {off:.2g})"
    acting = np.abs(factors) * np.abs(table).max(axis=0) > STRAIGHT * unit
    if acting.sum() > 1:
        return f"joint {step.name!r} follows several drives at once"
    if not acting.any():
        return Follower("", 0.0)
    k = int(np.flatnonzero(acting)[0])
    return Follower(list(drives)[k], _simple(float(factors[k])))


def _simple(factor: float) -> float:
    """The factor, or the simple ratio that it equals but for rounding, such as -1 in a parallelogram."""
    ratio = float(Fraction(factor).limit_denominator(12))
    return ratio if abs(ratio - factor) < ROUNDED * abs(factor) else factor
