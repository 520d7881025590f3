"""Errors and warnings of the library."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager


class FrameError(ValueError):
    """A description or argument is wrong; the message names the object, the value and the remedy."""


class MechanismWarning(UserWarning):
    """Some batch entries are kinematically unstable; their results are NaN and say so in `status`."""


class PathWarning(UserWarning):
    """An equilibrium path ended before it reached the displacement that it was followed to, or hides a limit point."""


class SampleWarning(UserWarning):
    """Samples do not tell all: some of a result are NaN, or none went where failures are likely; it says which."""


class CheckpointWarning(UserWarning):
    """A part of what an earlier run left on disk is damaged; it is computed again."""


@contextmanager
def expected_mechanisms() -> Iterator[None]:
    """No `MechanismWarning` in the body: entries that are kinematically unstable are part of its answer.

    Their status, and NaN, tell of them.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MechanismWarning)
        yield
