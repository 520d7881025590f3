"""Serialisation of chunks to bytes; reading them runs no code."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..moments import SUMS, Moments
from .blocks import BlockStatistics
from .chunk import ChunkResult
from .comoments import Comoments
from .failures import FailedRows, Reasons
from .histogram import Bins

Arrays = dict[str, NDArray[np.generic]]


def packed(found: ChunkResult) -> list[bytes | memoryview]:
    """A chunk as bytes, in pieces."""
    own = found.statistics
    arrays: Arrays = {"range": np.array([found.start, found.count]), "blocks": own.numbers}
    arrays |= {"least": own.least, "greatest": own.greatest} | _failed(found)
    if found.comoments is not None:
        parts = found.comoments
        arrays |= {
            f"comoments.{key}": np.stack([getattr(part, key) for part in parts]) for key in ("n", "mean", "second")
        }
        arrays |= _moments("scatter", Moments.stacked([part.scatter for part in parts]))
    if own.replicated is not None:
        arrays["replicated"] = own.replicated
    if found.bins is not None and found.counts is not None:
        arrays |= {"bins.center": found.bins.center, "bins.scale": found.bins.scale, "counts": found.counts}
    if found.samples is not None:
        arrays["samples"] = found.samples
    return packed_arrays(arrays)


def packed_arrays(arrays: Mapping[str, NDArray[Any]]) -> list[bytes | memoryview]:
    """Arrays by name as bytes: a line with name, type, shape and order of axes of each, then their data.

    The pieces are views of memory, as joining or reordering them would take as long as writing them. An archive with a
    file and a check sum for each array would take as long as the statistics of a chunk.
    """
    told, pieces = {}, list[bytes | memoryview]()
    for name, array in arrays.items():
        order = sorted(range(array.ndim), key=lambda axis: -array.strides[axis])
        laid = array.transpose(order)
        if not laid.flags.c_contiguous:
            order = list(range(array.ndim))
            laid = np.ascontiguousarray(array)
        told[name] = [np.lib.format.dtype_to_descr(array.dtype), list(array.shape), order]
        if array.nbytes:  # an array without bytes cannot be viewed as bytes
            pieces.append(laid.reshape(-1).view(np.uint8).data)
    return [json.dumps(told).encode() + b"\n", *pieces]


def unpacked_arrays(content: bytes) -> dict[str, NDArray[Any]]:
    """Arrays by name from their bytes, read-only, with the memory layout that they had."""
    start = content.index(b"\n") + 1
    out = {}
    for name, (kind, shape, order) in json.loads(content[:start]).items():
        fields = kind if isinstance(kind, str) else [tuple(field) for field in kind]
        dtype, count = np.lib.format.descr_to_dtype(fields), math.prod(shape)  # type: ignore[arg-type]
        # strings of no characters have no bytes
        some = count * dtype.itemsize > 0
        flat = np.frombuffer(content, dtype, count, start) if some else np.zeros(count, dtype)
        out[name] = flat.reshape([shape[axis] for axis in order]).transpose(np.argsort(order))
        start += count * dtype.itemsize
    return out


def unpacked(content: bytes) -> ChunkResult:
    """A chunk from its bytes."""
    arrays = unpacked_arrays(content)
    start, count = (int(each) for each in arrays["range"])
    comoments = bins = None
    if "comoments.n" in arrays:
        sums = (arrays[f"comoments.{key}"] for key in ("n", "mean", "second"))
        scatter = _moments_of("scatter", arrays).parts()
        comoments = [Comoments(*each) for each in zip(*sums, scatter, strict=True)]
    if "counts" in arrays:
        bins = Bins(arrays["bins.center"], arrays["bins.scale"])
    return ChunkResult(
        start,
        count,
        BlockStatistics(
            arrays["blocks"],
            arrays.get("replicated"),
            arrays["least"][()],
            arrays["greatest"][()],
        ),
        *_failed_of(arrays),
        comoments,
        bins,
        arrays.get("counts"),
        arrays.get("samples"),
    )


def _failed(found: ChunkResult) -> Arrays:
    """Arrays of the failed samples; none if no sample has failed."""
    failed = found.failed
    if not len(failed.rows) and failed.whole is None:
        return {}
    arrays: Arrays = {"missing": found.missing, "failed.rows": failed.rows}
    arrays |= _reasons("failed.reasons", failed.reasons)
    if failed.whole is not None and failed.otherwise is not None:
        arrays |= {"failed.whole": failed.whole} | _reasons("failed.otherwise", failed.otherwise)
    return arrays


def _failed_of(arrays: Mapping[str, NDArray[Any]]) -> tuple[NDArray[np.int64], FailedRows]:
    if "missing" not in arrays:
        return np.zeros(arrays["least"].shape, np.int64), FailedRows.none(None)
    reasons, whole, otherwise = _reasons_of("failed.reasons", arrays), None, None
    if "failed.whole" in arrays:
        whole, otherwise = arrays["failed.whole"], _reasons_of("failed.otherwise", arrays)
    return arrays["missing"], FailedRows(arrays["failed.rows"], reasons, whole, otherwise)


def _moments(name: str, parts: Moments) -> Arrays:
    return {f"{name}.{key}": np.asarray(getattr(parts, key)) for key in ("n", *SUMS)}


def _moments_of(name: str, arrays: Mapping[str, NDArray[Any]]) -> Moments:
    return Moments(*(arrays[f"{name}.{key}"] for key in ("n", *SUMS)))


def _reasons(name: str, found: Reasons) -> Arrays:
    return {f"{name}.texts": found.texts, f"{name}.which": found.which}


def _reasons_of(name: str, arrays: Mapping[str, NDArray[np.generic]]) -> Reasons:
    return Reasons(arrays[f"{name}.texts"], arrays[f"{name}.which"])  # type: ignore[arg-type]
