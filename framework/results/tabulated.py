"""Results as a pandas table or an xarray data set, with the names of batch axes that the frame gives."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..batch import Array
from ..dofs import DISPLACEMENTS, FORCES
from ..optional import imported
from .base import Results


def dimensions(results: Results) -> tuple[str, ...]:
    """Names of the batch axes: those of the frame, aligned with the last axes, or else ``axis_0``, ``axis_1``, ..."""
    count, named = len(results.shape), results.frame.axes
    return named[len(named) - count :] if named else tuple(f"axis_{k}" for k in range(count))


def to_dataframe(results: Results) -> Any:
    """Table with one row for each batch entry and node; see `SavedResults.to_dataframe`."""
    pandas = imported("pandas", "to_dataframe")
    shape, nodes = results.shape, list(results.frame.nodes)
    numbers = np.indices((*shape, len(nodes))).reshape(len(shape) + 1, -1)
    columns: dict[str, Any] = dict(zip(dimensions(results), numbers[:-1], strict=True))
    columns["node"] = np.array(nodes, dtype=object)[numbers[-1]]
    moved = np.broadcast_to(results.displacements(), (*shape, len(nodes), 6)).reshape(-1, 6)
    columns |= {name: moved[:, k] for k, name in enumerate(DISPLACEMENTS)}
    columns["status"] = np.repeat(np.broadcast_to(results.status, shape).reshape(-1), len(nodes))
    return pandas.DataFrame(columns)


def to_xarray(results: Results) -> Any:
    """Data set with named dimensions; see `SavedResults.to_xarray`."""
    xarray = imported("xarray", "to_xarray")
    frame, dims = results.frame, dimensions(results)
    tables: dict[str, tuple[str, str, list[str], Array]] = {
        "displacement": ("node", "component", list(frame.nodes), results.displacements()),
        "reaction": ("support", "force", list(frame.supports), results.reactions()),
    }
    if frame.joints:
        names = list(frame.joints)
        moves = [results.joint_displacement(name) for name in names]
        forces = [results.joint_force(name) for name in names]
        tables["joint_displacement"] = ("joint", "component", names, _stacked(moves))
        tables["joint_force"] = ("joint", "force", names, _stacked(forces))
    data: dict[str, Any] = {"status": (dims, np.broadcast_to(results.status, results.shape))}
    coords: dict[str, Any] = {"component": list(DISPLACEMENTS), "force": list(FORCES)}
    for name, (what, parts, names, values) in tables.items():
        if names:
            data[name] = ((*dims, what, parts), np.broadcast_to(values, (*results.shape, len(names), 6)))
            coords[what] = names
    return xarray.Dataset(data, coords)


def _stacked(parts: list[Array]) -> Array:
    return np.stack(np.broadcast_arrays(*parts), axis=-2)
