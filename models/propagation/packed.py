"""Chunks as bytes, without code that reading them would run."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..moments import Moments
from .chunk import ChunkResult
from .comoments import Comoments
from .failures import FailedRows, Reasons
from .histogram import Bins

Arrays = dict[str, NDArray[np.generic]]
_SUMS = ("mean", "second", "third", "fourth")


def packed(found: ChunkResult) -> bytes:
    """A chunk as bytes."""
    arrays: Arrays = {"range": np.array([found.start, found.count])}
    arrays |= _moments("blocks", found.blocks)
    arrays |= {"missing": found.missing, "least": found.least, "greatest": found.greatest}
    failed = found.failed
    arrays |= {"failed.rows": failed.rows} | _reasons("failed.reasons", failed.reasons)
    if failed.whole is not None and failed.otherwise is not None:
        arrays |= {"failed.whole": failed.whole} | _reasons("failed.otherwise", failed.otherwise)
    if found.comoments is not None:
        parts = found.comoments
        arrays |= {
            f"comoments.{key}": np.stack([getattr(part, key) for part in parts]) for key in ("n", "mean", "second")
        }
        arrays |= _moments("scatter", [part.scatter for part in parts])
    if found.replicated is not None:
        arrays |= _moments("replicated", found.replicated)
    if found.bins is not None and found.counts is not None:
        arrays |= {"bins.center": found.bins.center, "bins.scale": found.bins.scale, "counts": found.counts}
    if found.samples is not None:
        arrays["samples"] = found.samples
    return packed_arrays(arrays)


def packed_arrays(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays by name as bytes: a line that tells name, type and shape of each, and then their numbers.

    An archive, which keeps a file and a check sum for each, would take as long as the statistics of a chunk.
    """
    whole = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    told = {name: [whole[name].dtype.str, list(np.shape(array))] for name, array in arrays.items()}
    return b"".join([json.dumps(told).encode(), b"\n", *(array.tobytes() for array in whole.values())])


def unpacked_arrays(content: bytes) -> dict[str, NDArray[Any]]:
    """Arrays by name from their bytes; they cannot be written to."""
    start = content.index(b"\n") + 1
    out = {}
    for name, (kind, shape) in json.loads(content[:start]).items():
        dtype, count = np.dtype(kind), math.prod(shape)
        # Names of no characters have no bytes.
        some = count * dtype.itemsize > 0
        flat = np.frombuffer(content, dtype, count, start) if some else np.zeros(count, dtype)
        out[name] = flat.reshape(shape)
        start += count * dtype.itemsize
    return out


def unpacked(content: bytes) -> ChunkResult:
    """A chunk from its bytes."""
    arrays = unpacked_arrays(content)
    start, count = (int(each) for each in arrays["range"])
    comoments = bins = None
    whole = otherwise = None
    if "failed.whole" in arrays:
        whole, otherwise = arrays["failed.whole"], _reasons_of("failed.otherwise", arrays)
    if "comoments.n" in arrays:
        sums = (arrays[f"comoments.{key}"] for key in ("n", "mean", "second"))
        comoments = [Comoments(*each) for each in zip(*sums, _moments_of("scatter", arrays), strict=True)]
    if "counts" in arrays:
        bins = Bins(arrays["bins.center"], arrays["bins.scale"])
    return ChunkResult(
        start,
        count,
        _moments_of("blocks", arrays),
        arrays["missing"],
        arrays["least"][()],
        arrays["greatest"][()],
        FailedRows(arrays["failed.rows"], _reasons_of("failed.reasons", arrays), whole, otherwise),
        comoments,
        bins,
        arrays.get("counts"),
        arrays.get("samples"),
        _moments_of("replicated", arrays) if "replicated.n" in arrays else None,
    )


def _moments(name: str, parts: list[Moments]) -> Arrays:
    shape = np.shape(parts[0].mean)
    counts = np.stack([np.broadcast_to(part.n, shape) for part in parts])
    sums: Arrays = {f"{name}.{key}": np.stack([getattr(part, key) for part in parts]) for key in _SUMS}
    return {f"{name}.n": counts, f"{name}.single": np.array([np.ndim(part.n) == 0 for part in parts])} | sums


def _moments_of(name: str, arrays: Mapping[str, NDArray[np.generic]]) -> list[Moments]:
    out = []
    for row, single in enumerate(arrays[f"{name}.single"]):
        counts = arrays[f"{name}.n"][row]
        n = int(counts.flat[0]) if single and counts.size else counts
        out.append(Moments(n, *(arrays[f"{name}.{key}"][row] for key in _SUMS)))
    return out


def _reasons(name: str, found: Reasons) -> Arrays:
    return {f"{name}.texts": found.texts, f"{name}.which": found.which}


def _reasons_of(name: str, arrays: Mapping[str, NDArray[np.generic]]) -> Reasons:
    return Reasons(arrays[f"{name}.texts"], arrays[f"{name}.which"])  # type: ignore[arg-type]
