"""``linkframe four-bar``: the paper's job, every number of it an option."""

from __future__ import annotations

import math
import re
import sys
from argparse import Action, ArgumentDefaultsHelpFormatter, ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..four_bar.closure import BRANCHES
from ..job.output import add_output
from ..job.overrides import add_tolerance
from ..job.sharing import add_sharing
from ..moments import NAN_POLICIES
from ..sampling import SAMPLERS
from .inputs import Inputs

if TYPE_CHECKING:
    from argparse import _ArgumentGroup, _SubParsersAction

PAPER = Inputs()

DESCRIPTION = """\
Where the coupler point P of a four-bar really goes: rigid motion, compliance of links and joints, joint clearance,
and the spread of all of it under tolerances, at every pose. Without options it runs the example of the accuracy paper.
SI units, angles in degrees."""

WRITES = """\
writes into DIR: table1.csv, reactions.csv, measured.csv (with measured positions), trajectory.pvd with its .vtu files,
samples.npz, report.md; with --figures 2d index.html, which opens in a browser, figure5.png, figure6.png, figure7.png,
reactions.png, measured.png (with measured positions), and with --figures all figure3d.png as well (where rendering
works); with --format svg pdf those but figure3d as such"""


def add_to(jobs: _SubParsersAction[ArgumentParser]) -> None:
    """Add the subcommand ``four-bar`` to the jobs of the command line."""
    parser = jobs.add_parser(
        "four-bar",
        usage="%(prog)s [option ...]",
        help="accuracy of a four-bar linkage at every pose",
        description=DESCRIPTION,
        epilog=WRITES,
        formatter_class=_Formatter,
    )
    # Before Python 3.14 argparse takes -1e-3 for an option.
    parser._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$|-inf$", re.IGNORECASE)
    _linkage(parser.add_argument_group("linkage", "crank A-B, coupler B-P-D, rocker D-E; A = (0, 0), E = (ground, 0)"))
    _links(parser.add_argument_group("links"))
    _joints(parser.add_argument_group("joints B, D and E"))
    _load(parser.add_argument_group("load at P"))
    _run(parser.add_argument_group("run"))
    parser.set_defaults(run=_start)


def _linkage(group: _ArgumentGroup) -> None:
    for name in ("crank", "coupler", "rocker", "ground"):
        _add(group, name, positive, "M", f"length of the {name}")
    _add(group, "length-sd", not_negative, "M", "standard deviation of every length")
    group.add_argument(
        "--point", type=finite, nargs=2, metavar=("X", "Y"), default=PAPER.point,
        help="P in the coupler's axes: origin B, x towards D",
    )  # fmt: skip
    group.add_argument(
        "--branch", choices=sorted(BRANCHES), default=PAPER.branch,
        help="side on which D lies; by default parallel if opposite links are equal, else open",
    )  # fmt: skip


def _links(group: _ArgumentGroup) -> None:
    group.add_argument(
        "--section", type=positive, nargs=2, metavar=("M", "M"), default=PAPER.section, help="sides of the rectangle"
    )
    group.add_argument(
        "--in-plane", choices=("long", "short"), default=PAPER.in_plane, help="side in the plane of motion"
    )
    _add(group, "young", positive, "PA", "modulus of elasticity E")
    _add(group, "young-sd", not_negative, "PA", "its standard deviation, independent for each link")
    _add(group, "poisson", poisson, "NU", "Poisson's ratio")


def _joints(group: _ArgumentGroup) -> None:
    _add(
        group,
        "stiffness",
        positive_or_inf,
        "N/M",
        "stiffness in every direction but about the pin, where it is 0; inf is ideal",
    )
    _add(group, "stiffness-sd", not_negative, "N/M", "its standard deviation")
    _add(group, "clearance", not_negative, "M", "clearance ε")
    _add(group, "clearance-sd", not_negative, "M", "its standard deviation")
    group.add_argument(
        "--clearance-is", choices=("radius", "diameter"), default=PAPER.clearance_is,
        help="whether ε is the difference of the radii, as in Eq. (11), or of the diameters",
    )  # fmt: skip
    group.add_argument(
        "--closure", choices=("first-order", "exact"), default=PAPER.closure,
        help="displacement by the clearance: to first order, or the loop closed anew",
    )  # fmt: skip
    _add(
        group,
        "contact",
        angle_or_force,
        "DEG",
        "contact angle γ from global x; or 'reaction': along the joint's force without clearances; or 'equilibrium': "
        "along the one that the clearances leave",
    )
    _add(group, "contact-sd", not_negative, "DEG", "its standard deviation; not with reaction or equilibrium")
    group.add_argument(
        "--joints", choices=("independent", "shared"), default=PAPER.joints,
        help="whether each joint draws its own stiffness, clearance and contact angle, or all share one draw",
    )  # fmt: skip


def _load(group: _ArgumentGroup) -> None:
    _add(group, "load", finite, "N", "force along y")
    _add(group, "load-sd", not_negative, "N", "its standard deviation")


def _run(group: _ArgumentGroup) -> None:
    group.add_argument(
        "--poses",
        type=finite,
        nargs=3,
        metavar=("FIRST", "LAST", "STEP"),
        default=PAPER.poses,
        help="drive angles, degrees",
    )
    _add(group, "samples", at_least_two, "N", "samples at each pose")
    _add(group, "rng", seed, "SEED", "seed; the same seed gives the same bits")
    group.add_argument(
        "--sampler", choices=SAMPLERS, default=PAPER.sampler,
        help="how samples are drawn: random, by a Latin hypercube, or by a sequence that fills the space evenly",
    )  # fmt: skip
    group.add_argument(
        "--nan-policy", choices=NAN_POLICIES, default=PAPER.nan_policy,
        help="samples without a result: leave them out, leave their pose without statistics, or end",
    )  # fmt: skip
    group.add_argument(
        "--histogram-pose", type=finite, metavar="DEG", default=PAPER.histogram_pose,
        help="pose of figures 5 and 7, one of the poses; by default the regular pose nearest to 30",
    )  # fmt: skip
    group.add_argument(
        "--magnify", type=positive, metavar="FACTOR", default=PAPER.magnify,
        help="factor on the displacements in figure 6; by default one that shows them",
    )  # fmt: skip
    add_tolerance(
        group,
        "tolerance of a number in place of its standard deviation, in the unit of its option: an option such as load, "
        "clearance or crank, that of one joint or link such as clearance.B or young.crank, drive, fx, mz",
    )
    group.add_argument(
        "--measured", type=Path, metavar="CSV",
        help="table of measured positions of P, beside those predicted: columns x, y, z, ux, uy, uz (standard "
        "uncertainty) and 'A [deg]', the drive angle; without the latter measured at the poses of the run",
    )  # fmt: skip
    add_sharing(group)
    add_output(group, Path("results"))


def _add(group: _ArgumentGroup, name: str, kind: Callable[[str], Any], metavar: str, text: str) -> None:
    default = getattr(PAPER, name.replace("-", "_"))
    group.add_argument(f"--{name}", type=kind, metavar=metavar, default=default, help=text)


def _start(options: Namespace) -> None:
    # Not before the options are known to be good: this imports all of the numerics.
    from ..job.run import run
    from ..job.sharing import sharing
    from .job import FourBarJob

    names = [field.name for field in fields(Inputs)]
    given: dict[str, Any] = {
        name: tuple(value) if isinstance(value := getattr(options, name), list) else value for name in names
    }
    given["tolerance"] = given["tolerance"] or ()
    inputs = Inputs(**given)
    shared = sharing(options, inputs)
    job = FourBarJob(inputs, shared)
    for note in job.beforehand():
        print(f"linkframe four-bar: note: {note}", file=sys.stderr, flush=True)
    run(job, options.out, options.figures, options.format, options.wide, options.begun)


def finite(text: str) -> float:
    """A finite number."""
    return _number(text, math.isfinite, "a finite number")


def positive(text: str) -> float:
    """A finite number above zero."""
    return _number(text, lambda value: 0.0 < value < math.inf, "a finite number greater than 0")


def positive_or_inf(text: str) -> float:
    """A number above zero, or inf."""
    return _number(text, lambda value: value > 0.0, "a number greater than 0, or inf")


def not_negative(text: str) -> float:
    """A finite number, zero or above."""
    return _number(text, lambda value: 0.0 <= value < math.inf, "a finite number, 0 or greater")


def poisson(text: str) -> float:
    """Poisson's ratio of an isotropic solid."""
    return _number(text, lambda value: -1.0 < value < 0.5, "a number between -1 and 0.5, both excluded")


def at_least_two(text: str) -> int:
    """A number of samples that has a standard deviation."""
    return int(_number(text, lambda value: value >= 2 and value.is_integer(), "a whole number, 2 or greater"))


def seed(text: str) -> int:
    """A seed for NumPy's generator."""
    return int(_number(text, lambda value: value >= 0 and value.is_integer(), "a whole number, 0 or greater"))


def angle_or_force(text: str) -> float | str:
    """An angle in degrees, or a word that takes the angle from the joint's force."""
    if text in ("reaction", "equilibrium"):
        return text
    return _number(text, math.isfinite, "an angle in degrees, or the word reaction or equilibrium")


def _number(text: str, good: Callable[[float], bool], wanted: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not good(value):
        raise ArgumentTypeError(f"is {text!r}: give {wanted}")
    return value


class _Formatter(ArgumentDefaultsHelpFormatter):
    """Defaults as a reader writes them: none of what is off, several without brackets."""

    def _get_help_string(self, action: Action) -> str | None:
        default = action.default
        if default is None or default is False or default == "==SUPPRESS==":
            return action.help
        if isinstance(default, tuple | list | float):
            several = default if isinstance(default, tuple | list) else [default]
            shown = " ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in several)
            return f"{action.help} (default: {shown})"
        return super()._get_help_string(action)
