"""Effects of single choices: the outcome at one pose with each of them, one a line."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from .outcome import Outcome
from .tables import markdown, readable

# Largest number of samples for a choice.
COMPARED = 2000

EXPLAINED = """\
Each line changes one choice and keeps the rest, at {where} with the same seed{first}; mean and deviation with their
standard errors. The condition numbers are those of the mean inputs."""


def first(samples: int) -> str:
    """The number of samples in words, if not all are used."""
    return f", of the first {COMPARED} samples" if samples > COMPARED else ""


def as_markdown(outcomes: Iterable[tuple[str, Outcome]]) -> str:
    """The table for the report; each outcome has one pose."""
    heading, lines = ["choice"], []
    for name, outcome in outcomes:
        heads, cells = zip(*_cells(outcome), strict=True)
        heading = ["choice", *heads]
        lines.append([name, *cells])
    return markdown(heading, lines, left=1)


def _cells(outcome: Outcome) -> Iterable[tuple[str, str]]:
    yield "compliance, µm", micrometres(outcome)
    moved = outcome.mean - outcome.rigid
    for axis in outcome.axes:
        yield f"mean u_{'xyz'[axis]}, mm", in_millimetres(moved[0, axis], outcome.standard_error[0, axis])
    if outcome.count > 1:
        yield from deviations(outcome)
    yield "κ", readable(float(outcome.kappa[0]), ".3e")
    yield "κ scaled", readable(float(outcome.kappa_scaled[0]), ".3e")
    yield from condition_ranges(outcome)


def condition_ranges(outcome: Outcome) -> Iterable[tuple[str, str]]:
    """Headings and cells of the planar condition number, and of ranges over the samples, at the first pose."""
    whole, plane = (each[0] for each in outcome.sampled_kappa)
    if outcome.count > 1:
        yield "range of κ", _range(whole)
    yield "κ in the plane", readable(float(outcome.planar_kappa[0]), ".3e")
    if outcome.count > 1:
        yield "its range", _range(plane)


def _range(values: NDArray[np.float64]) -> str:
    least, greatest = bounds(values)
    return f"{readable(least, '.2e')} … {readable(greatest, '.2e')}"


def bounds(values: NDArray[np.float64]) -> tuple[float, float]:
    """Least and largest of the samples that have a value; NaN if none has."""
    known = values[~np.isnan(values)]
    return (float(known.min()), float(known.max())) if known.size else (np.nan, np.nan)


def deviations(outcome: Outcome) -> Iterable[tuple[str, str]]:
    """Headings and cells of the standard deviations at the first pose, with their standard errors."""
    for axis in outcome.axes:
        yield f"σ_{'xyz'[axis]}, mm", in_millimetres(outcome.std[0, axis], outcome.std_standard_error[0, axis])


def micrometres(outcome: Outcome) -> str:
    """Magnitude of the displacement by compliance at the first pose, in micrometres."""
    return f"{1e6 * np.linalg.norm(outcome.compliance[0]):.2f}"


def in_millimetres(value: float, error: float) -> str:
    """A length in metres with its standard error, in millimetres."""
    return f"{1e3 * value:.3f} ± {1e3 * error:.3f}" if np.isfinite(error) else readable(1e3 * value, ".3f")
