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

from ...framework.garbage import lasting
from ..four_bar.closure import BRANCHES
from ..job import run
from ..job.output import add_output
from ..job.overrides import add_tolerance
from ..job.sharing import add_sharing, sharing
from ..moments import NAN_POLICIES
from ..sampling import SAMPLERS
from . import job
from .inputs import LENGTHS, Inputs

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
    # before Python 3.14 argparse mistakes -1e-3 for an option
    parser._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$|-inf$", re.IGNORECASE)
    _linkage(parser.add_argument_group("linkage", "crank A-B, coupler B-P-D, rocker D-E; A = (0, 0), E = (ground, 0)"))
    _links(parser.add_argument_group("links"))
    _joints(parser.add_argument_group("joints B, D and E"))
    _load(parser.add_argument_group("load at P"))
    _run(parser.add_argument_group("run"))
    parser.set_defaults(run=_start)


def _linkage(group: _ArgumentGroup) -> None:
    for name in LENGTHS:
        _add(group, name, f"length of the {name}", type=positive, metavar="M")
    _add(group, "length-sd", "standard deviation of every length", type=not_negative, metavar="M")
    _add(group, "point", "P in the coupler's axes: origin B, x towards D", type=finite, nargs=2, metavar=("X", "Y"))
    _add(
        group,
        "branch",
        "side on which D lies; by default parallel if opposite links are equal, else open",
        choices=sorted(BRANCHES),
    )


def _links(group: _ArgumentGroup) -> None:
    _add(group, "section", "sides of the rectangle", type=positive, nargs=2, metavar=("M", "M"))
    _add(group, "in-plane", "side in the plane of motion", choices=("long", "short"))
    _add(group, "young", "modulus of elasticity E", type=positive, metavar="PA")
    _add(group, "young-sd", "its standard deviation, independent for each link", type=not_negative, metavar="PA")
    _add(group, "poisson", "Poisson's ratio", type=poisson, metavar="NU")


def _joints(group: _ArgumentGroup) -> None:
    stiffness = "stiffness in every direction but about the pin, where it is 0; inf is ideal"
    _add(group, "stiffness", stiffness, type=positive_or_inf, metavar="N/M")
    _add(group, "stiffness-sd", "its standard deviation", type=not_negative, metavar="N/M")
    _add(group, "clearance", "clearance ε", type=not_negative, metavar="M")
    _add(group, "clearance-sd", "its standard deviation", type=not_negative, metavar="M")
    _add(
        group,
        "clearance-is",
        "whether ε is the difference of the radii, as in Eq. (11), or of the diameters",
        choices=("radius", "diameter"),
    )
    _add(
        group,
        "closure",
        "displacement by the clearance: to first order, or the loop closed anew",
        choices=("first-order", "exact"),
    )
    contact = (
        "contact angle γ from global x; or 'reaction': along the joint's force without clearances; or 'equilibrium': "
        "along the one that the clearances leave"
    )
    _add(group, "contact", contact, type=angle_or_force, metavar="DEG")
    deviation = "its standard deviation; not with reaction or equilibrium"
    _add(group, "contact-sd", deviation, type=not_negative, metavar="DEG")
    _add(
        group,
        "joints",
        "whether each joint draws its own stiffness, clearance and contact angle, or all share one draw",
        choices=("independent", "shared"),
    )


def _load(group: _ArgumentGroup) -> None:
    _add(group, "load", "force along y", type=finite, metavar="N")
    _add(group, "load-sd", "its standard deviation", type=not_negative, metavar="N")


def _run(group: _ArgumentGroup) -> None:
    _add(group, "poses", "drive angles, degrees", type=finite, nargs=3, metavar=("FIRST", "LAST", "STEP"))
    _add(group, "samples", "samples at each pose", type=at_least_two, metavar="N")
    _add(group, "rng", "seed; the same seed gives the same bits", type=seed, metavar="SEED")
    sampler = "how samples are drawn: random, by a Latin hypercube, or by a sequence that fills the space evenly"
    _add(group, "sampler", sampler, choices=SAMPLERS)
    policy = "samples without a result: leave them out, leave their pose without statistics, or end"
    _add(group, "nan-policy", policy, choices=NAN_POLICIES)
    pose = "pose of figures 5 and 7, one of the poses; by default the regular pose nearest to 30"
    _add(group, "histogram-pose", pose, type=finite, metavar="DEG")
    factor = "factor on the displacements in figure 6; by default one that shows them"
    _add(group, "magnify", factor, type=positive, metavar="FACTOR")
    add_tolerance(
        group,
        "tolerance of a number in place of its standard deviation, in the unit of its option: an option such as load, "
        "clearance or crank, that of one joint or link such as clearance.B or young.crank, drive, fx, mz",
    )
    measured = (
        "table of measured positions of P, beside those predicted: columns x, y, z, ux, uy, uz (standard uncertainty) "
        "and 'A [deg]', the drive angle; without the latter measured at the poses of the run"
    )
    _add(group, "measured", measured, type=Path, metavar="CSV")
    add_sharing(group)
    add_output(group, Path("results"))


def _add(group: _ArgumentGroup, name: str, text: str, **kind: Any) -> None:
    """Add the option for one of the inputs, whose default is the paper's."""
    group.add_argument(f"--{name}", default=getattr(PAPER, name.replace("-", "_")), help=text, **kind)


def _start(options: Namespace) -> None:
    names = [field.name for field in fields(Inputs)]
    given: dict[str, Any] = {
        name: tuple(value) if isinstance(value := getattr(options, name), list) else value for name in names
    }
    given["tolerance"] = given["tolerance"] or ()
    inputs = Inputs(**given)
    shared = sharing(options, inputs)
    with lasting(alone=options.alone):
        four_bar = job.FourBarJob(inputs, shared)
    for note in four_bar.beforehand():
        print(f"linkframe four-bar: note: {note}", file=sys.stderr, flush=True)
    run.run(four_bar, options.out, options.figures, options.format, options.wide, options.begun)


def _number(wanted: str, good: Callable[[float], bool], kind: Callable[[float], Any] = float) -> Callable[[str], Any]:
    """Function that reads a number and refuses one that is not `good`, with `wanted` as the remedy."""

    def read(text: str) -> Any:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not good(value):
            raise ArgumentTypeError(f"is {text!r}: give {wanted}")
        return kind(value)

    return read


finite = _number("a finite number", math.isfinite)
positive = _number("a finite number greater than 0", lambda value: 0.0 < value < math.inf)
positive_or_inf = _number("a number greater than 0, or inf", lambda value: value > 0.0)
not_negative = _number("a finite number, 0 or greater", lambda value: 0.0 <= value < math.inf)
poisson = _number("a number between -1 and 0.5, both excluded", lambda value: -1.0 < value < 0.5)
at_least_two = _number("a whole number, 2 or greater", lambda value: value >= 2 and value.is_integer(), int)
seed = _number("a whole number, 0 or greater", lambda value: value >= 0 and value.is_integer(), int)
angle = _number("an angle in degrees, or the word reaction or equilibrium", math.isfinite)


def angle_or_force(text: str) -> Any:
    """An angle in degrees, or a word that takes the angle from the joint's force."""
    return text if text in ("reaction", "equilibrium") else angle(text)


class _Formatter(ArgumentDefaultsHelpFormatter):
    """Help texts with readable defaults: none for options that are off, several values without brackets."""

    def _get_help_string(self, action: Action) -> str | None:
        default = action.default
        if default is None or default is False or default == "==SUPPRESS==":
            return action.help
        if isinstance(default, tuple | list | float):
            several = default if isinstance(default, tuple | list) else [default]
            shown = " ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in several)
            return f"{action.help} (default: {shown})"
        return super()._get_help_string(action)
