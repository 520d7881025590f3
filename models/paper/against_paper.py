"""The report's section "Against the paper": each point with the numbers of this run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..four_bar.clearance import clearance_map
from ..four_bar.four_bar import FourBar
from ..job import choices
from ..job.outcome import SPECTRA
from ..job.tables import markdown, readable
from .compared_choices import ComparedChoices, compare_choices
from .formulas import equation_6, mean_direction
from .inputs import Inputs
from .printed import ORIGIN, Printed, printed
from .readings import readings

if TYPE_CHECKING:
    from .result import Result

# Rotation of P by a printed offset above which it is reported, degrees.
TURNED = 1.0

OTHER = "This run is not the paper's linkage: its printed numbers are laid beside Eq. (15), and not beside this run."


def points(result: Result, compared: ComparedChoices | None = None) -> list[str]:
    """The five points in which the paper errs or is silent, in Markdown.

    Parameters
    ----------
    result
        The run.
    compared
        Effects of the choices at the run's pose, if they are known already.

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
        *_silent(result, compared),
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
        f" measured from (l, 0). Here the printed values stand under these headings, and l = {ORIGIN:g} m is added to"
        " the first, so that all x are measured from A. Read so, the printed standard deviations of the regular rows"
        f" are {spread.min():.1f} to {spread.max():.1f} mm."
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
    degrees = result.degrees[shared]
    printed_at = np.array([table.row(angle)[:2] for angle in degrees])  # type: ignore[index]
    theirs = 1e3 * (printed_at - np.stack(_equation_15(degrees), axis=-1))
    turn, radial = _on_the_circle(printed_at, degrees)
    ours, error = (1e3 * values[shared, :2] for values in (result.mean - result.rigid, result.standard_error))
    yield (
        "Mean displacement of P from its rigid position, in mm; this run's with its standard error; and of the printed"
        " one how far it turns P on its circle about (l, 0), and how far it takes P out of it:"
    )
    yield markdown(
        ["θ", "printed, x", "printed, y", "here, x", "here, y", "printed, turn", "printed, outwards"],
        [
            [
                f"{degrees[row]:g}°",
                *(f"{value:+.1f}" for value in theirs[row]),
                *(f"{value:+.3f} ± {sd:.3f}" for value, sd in zip(ours[row], error[row], strict=True)),
                f"{turn[row]:+.1f}°",
                f"{radial[row]:+.1f}",
            ]
            for row in range(len(shared))
        ],
    )
    if result.inputs.is_paper_linkage and (error > 0.0).all():
        off = np.abs(theirs - ours) / error
        row, axis = np.unravel_index(np.argmax(off), off.shape)
        yield (
            f"At {degrees[row]:g}° the printed {'xy'[axis]} lies {off.max():.0f} standard errors from this run's mean:"
            " chance does not explain it."
        )
    if (np.abs(turn) > TURNED).any():
        yield _rotated(degrees, theirs, turn, radial)


def _on_the_circle(places: NDArray[np.float64], degrees: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Rotation about (l, 0), degrees, and radial displacement, mm, of `places` (rows, 2) from P's rigid positions."""
    start, end = (at @ [1.0, 1.0j] - ORIGIN for at in (np.stack(_equation_15(degrees), axis=-1), places))
    return np.degrees(np.angle(end / start)), 1e3 * (np.abs(end) - np.abs(start))


def _rotated(
    degrees: NDArray[np.float64],
    moved: NDArray[np.float64],
    turn: NDArray[np.float64],
    radial: NDArray[np.float64],
) -> str:
    """Paragraph on the large printed offsets, compared with those that clearance can cause."""
    rows = np.abs(turn) > TURNED
    motion = FourBar().move(np.radians(degrees[rows]))
    most = sum(np.linalg.norm(part[..., 0, :], axis=-1) for part in clearance_map(motion).values())
    gap = 1e3 * Inputs().clearance
    least, greatest = (pick(np.abs(turn[rows])) for pick in (np.min, np.max))
    sign = "−" if (turn[rows] < 0.0).all() else "+" if (turn[rows] > 0.0).all() else "±"
    return (
        f"At {', '.join(f'{angle:g}°' for angle in degrees[rows])} the printed offsets are a turn of P by"
        f" {sign}{least:.1f} to {sign}{greatest:.1f}° on its circle, as if the crank stood that far from θ about A:"
        f" they are up to {np.linalg.norm(moved[rows], axis=-1).max():.1f} mm long and leave the radius to within"
        f" {np.abs(radial[rows]).max():.1f} mm. Clearance does not turn a crank that is clamped: whatever the contact"
        f" angles, three clearances of {gap:g} mm move P along x by {gap * np.max(most):.2f} mm at most at these poses,"
        f" and {np.abs(moved[rows, 0]).max():.1f} mm are printed."
    )


def _mean_clearance(inputs: Inputs) -> str:
    if isinstance(inputs.contact, str):
        return "The contact angle follows the joint's force in this run, so that the clearance has a mean direction."
    if not inputs.has_normal_clearances:
        return "Clearance and contact angle have tolerances of their own in this run, and not those of the paper."
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
    singular = np.flatnonzero(result.singular)
    if not singular.size:
        yield "None of this run's poses is singular."
        return
    yield (
        "Linear mechanics has no displacement there; κ is that of the matrix as assembled, where in double precision"
        " anything above 10¹⁵ is singular. At large displacement the linkage turns until its links carry the load."
        " The displacement of P that the mean load then gives, without clearance, crank, coupler, rocker and joints"
        " being as elastic as they are, is finite:"
    )
    yield markdown(
        ["θ", "κ", "displacement of P, mm", "status"],
        [
            [
                f"{result.degrees[i]:g}°",
                readable(result.kappa[i], ".1e"),
                f"({readable(x, '+.4f')}, {readable(y, '+.3f')})",
                str(result.status[i]),
            ]
            for i, (x, y, _) in zip(singular, 1e3 * result.large_mean_inputs[singular], strict=True)
        ],
    )


def _silent(result: Result, compared: ComparedChoices | None) -> Iterable[str]:
    inputs, angle = result.inputs, float(result.degrees[result.pose])
    some = choices.first(inputs.samples)
    yield (
        f"Each line changes one choice and keeps the rest, at θ = {angle:g}° with the same seed{some}; σ with its"
        f" standard error. κ, of the whole matrix and of its rows and columns in the plane (u_x, u_y and the rotation"
        f" about z of every node), is given at the mean inputs, and as its range over {min(inputs.samples, SPECTRA)}"
        " samples."
    )
    if compared is None or compared.angle != angle:
        compared = compare_choices(inputs, angle)
    yield markdown(list(compared.lines[0]), [list(line.values()) for line in compared.lines], left=1)
    yield (
        "ν, and with it G, and the torsion constant J move nothing in a linkage that is loaded in its plane; only κ of"
        " the whole matrix knows of them."
    )
    yield from _conditions(result, printed(), compared.kappa)
    yield from _readings(printed())


def _conditions(result: Result, table: Printed, sampled: tuple[float, float]) -> Iterable[str]:
    """κ of both matrices compared with the printed one, at the printed poses."""
    rows = [i for i in np.flatnonzero(result.regular) if table.row(result.degrees[i])]
    if not (rows and result.inputs.is_paper_linkage and result.has_kappa):
        return
    degrees, whole, plane = result.degrees[rows], result.kappa[rows], result.planar_kappa[rows]
    theirs = np.array([table.row(angle)[4] for angle in degrees])  # type: ignore[index]
    yield "κ in the 2-norm at the mean inputs, of the whole matrix (36 × 36) and in the plane (18 × 18):"
    yield markdown(
        ["θ", "κ", "κ in the plane", "printed κ"],
        [
            [f"{angle:g}°", *(f"{value:.3e}" for value in values)]
            for angle, *values in zip(degrees, whole, plane, theirs, strict=True)
        ],
    )
    near = int(np.argmin(np.abs(plane / theirs - 1.0)))
    far = int(np.argmax(np.abs(np.log(plane / theirs))))
    inside = bool(np.any((theirs >= min(sampled[0], whole.min())) & (theirs <= max(sampled[1], whole.max()))))
    yield (
        f"The printed κ are {theirs.min():.3e} to {theirs.max():.3e}. The whole matrix gives {whole.min():.3e} to"
        f" {whole.max():.3e} at these poses, {sampled[0]:.3e} to {sampled[1]:.3e} over the samples at"
        f" {result.degrees[result.pose]:g}°, and {'reaches some of them' if inside else 'reaches none of them'}. In the"
        f" plane it is {plane[near]:.3e} at {degrees[near]:g}°, {100.0 * abs(plane[near] / theirs[near] - 1.0):.0f} %"
        f" from the printed one, and {plane[far]:.3e} at {degrees[far]:g}°, where {theirs[far]:.3e} is printed."
        f"{_trend(degrees, whole, plane, theirs)} Which matrix and which norm were meant is not said."
    )


def _trend(degrees: NDArray[np.float64], *columns: NDArray[np.float64]) -> str:
    """Sentence on the trend of κ from 30° to 90°, and on its difference between 30° and the mirror image 150°."""
    at = {angle: np.flatnonzero(np.isclose(degrees, angle)) for angle in (30.0, 90.0, 150.0)}
    if not all(found.size for found in at.values()):
        return ""
    first, middle, last = (int(found[0]) for found in at.values())
    ways = [
        f"{'rises' if column[middle] > column[first] else 'falls'} to {column[middle] / column[first]:.2f}"
        for column in columns
    ]
    apart = [f"{100.0 * abs(column[last] / column[first] - 1.0):.1f} %" for column in columns]
    return (
        f" From 30° to 90° the whole matrix's {ways[0]} times its value, that in the plane {ways[1]}, the printed one"
        f" {ways[2]}; at 30° and 150°, which are mirror images, they differ by {apart[0]}, {apart[1]} and {apart[2]}."
    )


def _readings(table: Printed) -> Iterable[str]:
    """Standard deviations by different readings of the clearances' distributions, compared with the printed ones."""
    theirs = np.stack([table.std_x, table.std_y], axis=-1)[table.regular]
    degrees = table.theta[table.regular]
    found = readings(table)
    count = theirs.size
    yield (
        f"Standard deviation of P by the paper's clearances alone, of the whole population and to first order, in mm"
        f" over the {len(degrees)} regular rows, for readings of what is not said; and how many of the {count} printed"
        " values it gives when rounded as they are:"
    )
    yield markdown(
        ["reading", "σ_x", "σ_y", f"equal of {count}"],
        [[each.name, *map(_span, each.std.T), str(each.equal(theirs))] for each in found],
        left=1,
    )
    best = max(found, key=lambda each: each.equal(theirs))
    yield (
        f"Among these the reading that fits best is *{best.name}*: σ_x is {_span(best.std[:, 0])} mm and σ_y"
        f" {_span(best.std[:, 1])} mm, and {best.equal(theirs)} of the {count} printed values are equal."
    )
    closed = [each for each in found if each.closed]
    least = np.min([each.std for each in closed], axis=0)
    row, axis = np.unravel_index(np.argmax(least - theirs), theirs.shape)
    yield (
        f"A loop that is closed again cannot give the printed row at {degrees[row]:g}°: of all these readings with a"
        f" closed loop the least σ_{'xy'[axis]} there is {1e3 * least[row, axis]:.2f} mm, and"
        f" {1e3 * theirs[row, axis]:.1f} mm are printed. This run closes the loop."
    )


def _span(std: NDArray[np.float64]) -> str:
    """Range of deviations in metres as text, in mm; one number if they are equal."""
    low, high = (f"{1e3 * value:.3f}" for value in (std.min(), std.max()))
    return low if low == high else f"{low} to {high}"


def _equation_15(degrees: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Position of P in the paper's example, from A."""
    position = FourBar().move(np.radians(degrees)).position("P")
    return position[:, 0], position[:, 1]
