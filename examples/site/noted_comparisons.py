"""A plugin of pytest that notes what ``assert_allclose`` compares, by the test that does it."""

import json
import os
from pathlib import Path

import numpy as np
import numpy.testing
import pytest

MANY = 3  # comparisons of one test that are listed: those that are furthest apart

_meant: list[tuple[float, str, str]] = []
_files: dict[str, dict] = {}
_compare = numpy.testing.assert_allclose


def _noting(actual, desired, *args, **kwargs):
    _compare(actual, desired, *args, **kwargs)
    given, wanted = (np.asarray(side) for side in np.broadcast_arrays(actual, desired))
    counted = np.isfinite(given) & np.isfinite(wanted) & (wanted != 0) if given.dtype.kind in "fiu" else np.array(False)
    if not counted.any():
        return
    apart = np.where(counted, np.abs(given - wanted) / np.where(counted, np.abs(wanted), 1.0), -1.0)
    at = np.unravel_index(apart.argmax(), apart.shape)
    _meant.append((float(apart[at]), f"{wanted[at]:.10g}", f"{given[at]:.10g}"))


numpy.testing.assert_allclose = _noting


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
    for apart, wanted, given in sorted(_meant, reverse=True)[:MANY]:
        told["rows"].append([f"{name}{part}. {source}", wanted, given, f"{apart:.0e}" if apart else "0"])


def pytest_sessionfinish():
    files = {name: told for name, told in _files.items() if told["rows"]}
    Path(os.environ["NOTED_COMPARISONS"]).write_text(json.dumps(files), encoding="utf-8")
