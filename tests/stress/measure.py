"""True error and stated bound of all results of one structure."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from linkframe.framework import MechanismWarning
from reference.as_frame import as_frame
from reference.stiffness_method import Result, mp, solve
from reference.structure import Structure

Array = np.ndarray[Any, np.dtype[Any]]

# Below this share of the greatest result the reference itself is not sure: it holds an ideal joint by a spring of 1e30.
_SURE = 1e-18
KINDS = ("displacement", "reaction", "joint_displacement", "joint_force")


@dataclass(frozen=True)
class Measured:
    """Results of one kind at one place on an axis, each relative to the greatest component of its node or joint.

    Attributes
    ----------
    axis, x, kind
        Where, and of what.
    error, bound
        Greatest true error and greatest stated bound.
    refined_error, refined_bound
        The same of the refined results.
    lies
        How many numbers are further off than is stated.
    status
        What the solution says of itself.
    """

    axis: str
    x: float
    kind: str
    error: float
    bound: float
    refined_error: float
    refined_bound: float
    lies: int
    status: str


def measured(axis: str, x: float, structure: Structure) -> list[Measured]:
    """All kinds of results of a structure beside 50 digits.

    Raises
    ------
    AssertionError
        Where a NaN is not announced by the status.
    """
    solution = as_frame(structure).solve()
    status = str(solution.status)
    if status == "mechanism":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MechanismWarning)
            assert np.isnan(solution.displacement(next(iter(structure.loads)))).all()
        return [Measured(axis, x, "displacement", np.nan, np.inf, np.nan, np.inf, 0, status)]
    exact = solve(structure)
    return [one for kind in KINDS if (one := _kind(axis, x, kind, solution, exact)) is not None]


def _kind(axis: str, x: float, kind: str, solution: Any, exact: Result) -> Measured | None:
    truth: Mapping[str, Array] = {
        "displacement": exact.displacement,
        "reaction": exact.reaction,
        "joint_displacement": exact.extension,
        "joint_force": exact.force,
    }[kind]
    if not truth:
        return None
    whole = exact.displacement if kind == "joint_displacement" else truth
    floor = _SURE * max(float(abs(part)) for vector in whole.values() for part in vector)
    sizes = np.maximum([[float(abs(part)) for part in vector] for vector in truth.values()], floor)
    errors, bounds, better, left, lies = [], [], [], [], 0
    for name, vector in truth.items():
        found, bound = getattr(solution, kind)(name), solution.error_bound(name, kind)
        assert np.isfinite(found).all(), f"{axis} {x}: {kind} of {name} is {found} and not announced"
        refined, doubt = solution.refined(name, kind)
        errors.append(off(found, vector))
        better.append(off(refined, vector))
        bounds.append(bound)
        left.append(doubt)
        lies += int(np.sum(errors[-1] > bound + floor) + np.sum(better[-1] > doubt + floor))
    scale = np.repeat(sizes.reshape(-1, 2, 3).max(axis=(0, 2)), 3)
    greatest = (float(np.max(np.array(values) / scale)) for values in (errors, bounds, better, left))
    error, bound, refined_error, refined_bound = greatest
    return Measured(axis, x, kind, error, bound, refined_error, refined_bound, lies, str(solution.status))


def of_tip(axis: str, x: float, structure: Structure, exact: Array) -> Measured:
    """The displacement of the one loaded node beside its exact value (6,)."""
    solution = as_frame(structure).solve()
    status = str(solution.status)
    if status == "mechanism":
        return Measured(axis, x, "displacement", np.nan, np.inf, np.nan, np.inf, 0, status)
    (node,) = structure.loads
    found, bound = solution.displacement(node), solution.error_bound(node)
    refined, doubt = solution.refined(node)
    sizes = np.array([float(abs(part)) for part in exact])
    scale = np.repeat(sizes.reshape(2, 3).max(axis=1), 3)
    error, better = off(found, exact), off(refined, exact)
    lies = int(np.sum(error > bound) + np.sum(better > doubt))
    greatest = (float(np.max(each / scale)) for each in (error, bound, better, doubt))
    return Measured(axis, x, "displacement", *greatest, lies, status)


def off(found: Array, exact: Array) -> Array:
    """Error of double precision results, rounded down so that it is never overstated."""
    return np.array([float(abs(mp.mpf(float(a)) - b)) for a, b in zip(found, exact, strict=True)])
