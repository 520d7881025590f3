"""What all tests share: hypothesis draws the same examples on every machine, and no deadline on a busy one.

A test that states an absolute tolerance allows that much and no more: NumPy would add a relative one of 1e-7.

No test leaves machine code in the user's folder, nor takes it from there, and none finds programs of what others have
solved: which way a batch is solved does not depend on the order of the tests. Each process calculates in one thread, as
several side by side would wait for each other.
"""

from __future__ import annotations

import functools
import gc
import os
import sys
from typing import Any

# before NumPy is loaded, which reads them
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import numpy.testing  # noqa: E402
import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

_assert_allclose = numpy.testing.assert_allclose


@functools.wraps(_assert_allclose)
def assert_allclose(actual: Any, desired: Any, *tolerances: float, **named: Any) -> None:
    """That of NumPy, without its relative tolerance where an absolute one alone is given."""
    if "atol" in named and not tolerances:
        named.setdefault("rtol", 0.0)
    _assert_allclose(actual, desired, *tolerances, **named)


# before any test imports it
numpy.testing.assert_allclose = assert_allclose
os.environ["LINKFRAME_CACHE"] = "off"
settings.register_profile("linkframe", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("linkframe")


# Garbage is sought seldom: of what a test leaves, nearly all goes without.
gc.set_threshold(5000, 20, 20)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    """What one test solves is new to it."""
    if (cache := sys.modules.get("linkframe.framework.cache")) is not None:
        cache.PROGRAMS.clear()


def spare_what_is_there() -> None:
    """Let garbage be sought among what is made from now on: what is loaded and kept by now, nearly all of it, stays."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """To look through all that is loaded takes longer than most tests do."""
    spare_what_is_there()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Nor through what the files before have left in the caches; figures that were drawn are closed."""
    if (drawn := sys.modules.get("matplotlib.pyplot")) is not None:
        drawn.close("all")
    if nextitem is not None and nextitem.path != item.path:
        spare_what_is_there()
