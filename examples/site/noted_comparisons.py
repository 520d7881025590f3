"""A plugin of pytest that notes what ``assert_allclose`` and ``approx`` compare, by the test that does it."""

import json
import os
from pathlib import Path

import numpy as np
import numpy.testing
import pytest

MANY = 3  # comparisons of one test that are listed: those that are furthest apart; one where it runs for several cases
SMALL = 1e-6  # a number below this share of the greatest of its array is zero there, and is not compared by ratio

TINY = 1e-12  # of numbers of order one, rounding
_meant: list[tuple[float, str, str]] = []
_files: dict[str, dict] = {}
_compare = numpy.testing.assert_allclose


def _noting(actual, desired, *args, **kwargs):
    _compare(actual, desired, *args, **kwargs)
    _note(actual, desired, kwargs.get("atol", args[1] if len(args) > 1 else 0.0))


def _note(actual, desired, allowed):
    """Note the worst entry of a comparison that allows entries to be off by `allowed`."""
    given, wanted = (np.asarray(side) for side in np.broadcast_arrays(actual, desired))
    if given.dtype.kind not in "fiu":
        return
    size = np.abs(wanted)
    counted = np.isfinite(given) & np.isfinite(wanted) & (wanted != 0)
    # What is allowed to be off by as much as it is has no digits to compare.
    counted &= (size >= SMALL * size.max(initial=0.0, where=counted)) & (size > allowed) & (size > TINY)
    if not counted.any():
        return
    apart = np.where(counted, np.abs(given - wanted) / np.where(counted, np.abs(wanted), 1.0), -1.0)
    at = np.unravel_index(apart.argmax(), apart.shape)
    _meant.append((float(apart[at]), f"{wanted[at]:.10g}", f"{given[at]:.10g}"))


numpy.testing.assert_allclose = _noting
_Near = type(pytest.approx(1.0))
_is_near = _Near.__eq__


def _noting_near(self, actual):
    near = _is_near(self, actual)
    if near and isinstance(self.expected, int | float):
        _note(actual, self.expected, self.tolerance if self.rel is None else 0.0)
    return near


_Near.__eq__ = _noting_near


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call(item):
    _meant.clear()
    yield
    path = Path(item.path)
    title = " ".join((item.module.__doc__ or path.stem).split("\n\n")[0].split()).rstrip(".")
    told = _files.setdefault(path.name, {"title": title, "rows": []})
    name = item.function.__name__.removeprefix("test_").replace("_", " ").capitalize()
    source = (item.function.__doc__ or "").split("\n\n")[0]
    part = f" ({item.callspec.id})" if hasattr(item, "callspec") else ""
    text = f"{name}{part}. {source}"
    for apart, wanted, given in sorted(set(_meant), reverse=True)[: 1 if part else MANY]:
        told["rows"].append([text, wanted, given, f"{apart:.0e}" if apart else "0"])
        text = "the same"


def pytest_sessionfinish():
    files = {name: told for name, told in _files.items() if told["rows"]}
    Path(os.environ["NOTED_COMPARISONS"]).write_text(json.dumps(files), encoding="utf-8")
