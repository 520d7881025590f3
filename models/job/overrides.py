"""The option of the command line for tolerances."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError, _ArgumentGroup

WORDS = (
    "; as '± 0.1', '± 5 %%', '+0.2/-0.1' (evenly between these limits, or with normal behind it three standard "
    "deviations), or a distribution of scipy.stats, 'norm(0.1, 0.002)', 'norm(scale=5 %%)'; may be given several times"
)


def add_tolerance(parser: ArgumentParser | _ArgumentGroup, of: str) -> None:
    """Add the option for a tolerance.

    Parameters
    ----------
    parser
        Parser to which it is added.
    of
        Description of the numbers that can have a tolerance.
    """
    parser.add_argument("--tolerance", type=_pair, action="append", metavar="NAME=VALUE", help=of + WORDS)


def _pair(text: str) -> tuple[str, str]:
    name, equal, value = (part.strip() for part in text.partition("="))
    if not (name and equal and value):
        raise ArgumentTypeError(f"is {text!r}: give NAME=VALUE, such as 'joints.B.clearance=± 5 %'")
    return name, value
