"""The report's section "Against the paper": each point with the numbers of this run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..job.tables import markdown, readable
from .paper import equation_6, finite_rotation, mean_direction
from .result import compute
from .table import Printed, printed

if TYPE_CHECKING:
    from .inputs import Inputs
    from .result import Result

# Spectra cost far more than solutions.
SPECTRA = 200

OTHER = "This run is not the paper's linkage: its printed numbers are laid beside Eq. (15), and not beside this run."


def points(result: Result) -> list[str]:
    """The five points in which the paper errs or is silent, in Markdown.

    Parameters
    ----------
    result
        The run.

    Returns
    -------
    list of str
        Paragraphs.
    """
    table = printed()
    return [
        *(() if result.inputs.is_paper_linkage else (OTHER,)),
        "### 1. Eq. (6) is not a beam",
        *_beam_matrix(result),
        "### 2. The headings of Table 1 are permuted",
        _headings(table),
        "### 3. The printed mean offsets do not follow from the inputs",
        *_offsets(result, table),
        "### 4. The singular rows are round-off",
        *_singular(result, table),
        "### 5. What the paper does not say",
        *_silent(result),
    ]


def _beam_matrix(result: Result) -> Iterable[str]:
    theirs, true = equation_6(result.beam, result.inputs.crank)
    force = result.inputs.load or 100.0
    flexed = [1e3 * np.array(matrix.cantilever(force)) for matrix in (theirs, true)]
    carried = [matrix.matrix[11, 5] / true.matrix[5, 5] * 4.0 for matrix in (theirs, true)]
    yield (
        "`[[k, −k], [−k, k]]` with the k of Eq. (7), and the true matrix, which is used here, both written for this"
        " run's crank:"
    )
    yield markdown(
        ["", "must be", "Eq. (6)", "beam"],
        [
            [
                "largest end force (N) or moment (N m) after a rigid turn of 1 mrad",
                "0",
                *(f"{matrix.rigid_turn(1e-3):.4g}" for matrix in (theirs, true)),
            ],
            [
                "change when the ends are exchanged, relative to the largest entry",
                "0",
                *(f"{matrix.exchange():.1e}" for matrix in (theirs, true)),
            ],
            ["far-end moment of a unit near-end rotation, times L/(EI)", "+2", *(f"{value:+.3g}" for value in carried)],
            [f"tip deflection of a cantilever under {force:g} N, mm", "", *(f"{tip[0]:.5f}" for tip in flexed)],
            ["its tip rotation, mrad", "> 0", *(f"{tip[1]:+.4f}" for tip in flexed)],
        ],
        left=1,
    )
    yield (
        "With Eq. (6) a link that turns as a rigid body is under load, and a tip that is pushed up rotates downwards."
        " The coupling and far-end blocks need other signs on 6EI/L², and 2EI/L in place of 4EI/L."
    )


def _headings(table: Printed) -> str:
    keep = table.regular
    x, y = _equation_15(table.theta)
    third, first = (1e3 * np.abs(off)[keep].max() for off in (table.mean_y - y, table.mean_x - x))
    spread = 1e3 * np.concatenate([table.std_x[keep], table.std_y[keep]])
    lowest = np.argmin(np.where(keep, table.mean_y, np.inf))
    return (
        f"The column headed σ_x holds {table.mean_y[lowest]:g} at {table.theta[lowest]:g}°, and no standard deviation"
        f" is negative. On the {keep.sum()} regular rows it follows y = l sin θ to within {third:.1f} mm, the column"
        f" headed μ_x follows x − l = l cos θ to within {first:.1f} mm. So the order is μ_x − l, σ_x, μ_y, σ_y, with x"
        " measured from (l, 0); here the printed values stand under these headings. Read so, the printed standard"
        f" deviations of the regular rows are {spread.min():.1f} to {spread.max():.1f} mm."
    )


def _offsets(result: Result, table: Printed) -> Iterable[str]:
    flex = 1e6 * np.linalg.norm(result.compliance[result.regular], axis=-1)
    yield (
        f"{_mean_clearance(result.inputs)} Compliance under the mean load moves P by {flex.min():.1f} to"
        f" {flex.max():.0f} µm at regular poses."
    )
    shared = [i for i in np.flatnonzero(result.regular) if table.row(result.degrees[i])]
    if not shared:
        yield "None of this run's regular poses is printed."
        return
    theirs = 1e3 * np.array([table.row(result.degrees[i])[:2] for i in shared])  # type: ignore[index]
    theirs -= 1e3 * np.stack(_equation_15(result.degrees[shared]), axis=-1)
    ours, error = (1e3 * values[shared, :2] for values in (result.mean - result.rigid, result.standard_error))
    yield "Mean displacement of P from its rigid position, in mm; this run's with its standard error:"
    yield markdown(
        ["θ", "printed, x", "printed, y", "here, x", "here, y"],
        [
            [
                f"{result.degrees[pose]:g}°",
                *(f"{value:+.1f}" for value in theirs[row]),
                *(f"{value:+.3f} ± {sd:.3f}" for value, sd in zip(ours[row], error[row], strict=True)),
            ]
            for row, pose in enumerate(shared)
        ],
    )
    if result.inputs.is_paper_linkage and (error > 0.0).all():
        off = np.abs(theirs - ours) / error
        row, axis = np.unravel_index(np.argmax(off), off.shape)
        yield (
            f"At {result.degrees[shared[row]]:g}° the printed {'xy'[axis]} lies {off.max():.0f} standard errors from"
            " this run's mean: chance does not explain it."
        )


def _mean_clearance(inputs: Inputs) -> str:
    if isinstance(inputs.contact, str):
        return "The contact angle follows the joint's force in this run, so that the clearance has a mean direction."
    factor = mean_direction(inputs.contact, inputs.contact_sd)
    return (
        f"γ = {inputs.contact:g}° + {inputs.contact_sd:g}°ξ makes E[ε cos γ] = {factor:.4g} ε, which is"
        f" {1e6 * factor * inputs.clearance:.3g} µm for the mean ε of {1e3 * inputs.clearance:g} mm."
    )


def _singular(result: Result, table: Printed) -> Iterable[str]:
    rows = ~table.regular
    spread = np.concatenate([table.mean_y[rows], table.std_y[rows]])
    yield (
        f"At {', '.join(f'{angle:g}°' for angle in table.theta[rows])} the paper prints {spread.min():.1e} to"
        f" {spread.max():.1e} m. There coupler and rocker lie in line and the stiffness matrix is singular: the numbers"
        " are the rounding of a division by zero."
    )
    singular = np.flatnonzero(result.motion.singular)
    if not singular.size:
        yield "None of this run's poses is singular."
        return
    yield (
        "This run does not solve these poses and says so; κ is that of the matrix as assembled, where in double"
        " precision anything above 10¹⁵ is singular. With finite rotations the linkage turns until its stretched links"
        " carry the load. The displacement of P that the mean load then gives, coupler, rocker and joints taken as one"
        " spring in line and without bending, is finite:"
    )
    moved = [1e3 * finite_rotation(result.motion, int(i), result.inputs.load, result.line_stiffness) for i in singular]
    yield markdown(
        ["θ", "κ", "displacement of P, mm", "status"],
        [
            [
                f"{result.degrees[i]:g}°",
                readable(result.kappa[i], ".1e"),
                f"({x:+.2f}, {y:+.2f})",
                str(result.status[i]),
            ]
            for i, (x, y) in zip(singular, moved, strict=True)
        ],
    )


def _silent(result: Result) -> Iterable[str]:
    inputs, angle = result.inputs, result.degrees[result.pose]
    yield (
        f"Each line changes one choice and keeps the rest, at θ = {angle:g}° with the same seed. κ is given at the mean"
        f" inputs, and as its range over {min(inputs.samples, SPECTRA)} samples."
    )
    lines = []
    for name, change in _choices(inputs).items():
        other = compute(inputs.but(poses=(angle, angle, 1.0), histogram_pose=None, **change))
        flex, std = 1e6 * np.linalg.norm(other.compliance[0]), 1e3 * other.std[0]
        if inputs.samples > SPECTRA:
            other = compute(other.inputs.but(samples=SPECTRA))
        kappa = other.sampled_kappa[0]
        lines.append(
            [
                name,
                f"{flex:.2f}",
                *(f"{value:.3f}" for value in std[:2]),
                readable(other.kappa[0], ".4e"),
                f"{readable(kappa.min(), '.3e')} … {readable(kappa.max(), '.3e')}",
            ]
        )
    yield markdown(["choice", "compliance, µm", "σ_x, mm", "σ_y, mm", "κ", "range of κ"], lines, left=1)
    yield (
        "ν, and with it G, and the torsion constant J move nothing in a linkage that is loaded in its plane; only κ"
        f" knows of them.{_mirror(result)}{_growth(result)}"
    )


def _choices(inputs: Inputs) -> Mapping[str, Mapping[str, object]]:
    side = "short" if inputs.in_plane == "long" else "long"
    draws = "shared" if inputs.joints == "independent" else "independent"
    gap = "diameter" if inputs.clearance_is == "radius" else "radius"
    nu = 0.0 if inputs.poisson else 0.3
    choices: dict[str, dict[str, object]] = {
        "this run": {},
        f"the {side} side of the section in the plane": {"in_plane": side},
        f"ν = {nu:g}": {"poisson": nu},
        f"{draws} draws of k, ε, γ in the joints": {"joints": draws},
        f"ε on the {gap}": {"clearance_is": gap},
        "contact along the joint's force": {"contact": "reaction"},
    }
    if isinstance(inputs.contact, str) or not inputs.load:
        del choices["contact along the joint's force"]
    return choices


def _mirror(result: Result) -> str:
    """Say that κ differs between mirror images only if it was taken from different samples."""
    poses = [np.flatnonzero(np.isclose(result.degrees, angle)) for angle in (30.0, 150.0)]
    if not result.inputs.is_paper_linkage or not all(found.size for found in poses):
        return ""
    here, there = (float(result.kappa[found[0]]) for found in poses)
    return (
        f" The poses 30° and 150° are mirror images; κ is {readable(here, '.4e')} and {readable(there, '.4e')} here at"
        " the mean inputs, and 5.6899e8 and 5.4873e8 printed: the printed ones belong to random samples."
    )


def _growth(result: Result) -> str:
    """Say that clearance grows round the loop towards a singular pose, and that the printed spread does not."""
    poses = [np.flatnonzero(np.isclose(result.degrees, angle) & result.regular) for angle in (90.0, 350.0)]
    if not result.inputs.is_paper_linkage or not all(found.size for found in poses):
        return ""
    far, near = (1e3 * float(result.std[found[0], 1]) for found in poses)
    return (
        f" Clearance that is carried round the loop grows towards the singular poses: σ_y is {far:.2f} mm at 90° and"
        f" {near:.2f} mm at 350° here. The printed one, 0.3 and 0.4 mm, does not, and how the other links were placed"
        " anew is not said."
    )


def _equation_15(degrees: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Position of P in the paper's example, measured from (l, 0)."""
    theta = np.radians(degrees)
    return 0.1 * np.cos(theta), 0.1 * np.sin(theta)
