"""The numbers of a study as a pandas DataFrame or an xarray Dataset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.optional import imported
from ...propagation import Propagation
from ..worst_case.contributors import Contributors

AXES = ("x", "y", "z")
# Dimensions of the arrays of a study by their number of axes.
DIMS = {1: ("pose",), 2: ("point", "pose"), 3: ("point", "pose", "axis")}


class Tabulated(Protocol):
    """The part of a study that a table needs."""

    @property
    def points(self) -> tuple[str, ...]:
        """Names of the points."""

    @property
    def propagation(self) -> Propagation:
        """Samples of the displacement, (samples, points, poses, 3)."""

    @property
    def drives(self) -> dict[str, Array]:
        """Values of the drives, (poses,) each."""

    @property
    def status(self) -> NDArray[np.str_]:
        """Why a pose has no result, or ``"regular"``, (poses,)."""

    @property
    def contributors(self) -> Mapping[str, Contributors]:
        """Contributors by point."""

    def arrays(self) -> dict[str, Array]:
        """Numbers by name, (points, poses) or (points, poses, 3)."""


def to_dataframe(study: Tabulated) -> Any:
    """DataFrame with a row for each point and pose; see `AccuracyStudy.to_dataframe`."""
    pandas = imported("pandas", "to_dataframe")
    poses = len(study.status)
    columns: dict[str, Any] = {
        "point": np.repeat(study.points, poses),
        "pose": np.tile(np.arange(poses), len(study.points)),
    }
    columns |= {name: np.tile(values, len(study.points)) for name, values in study.drives.items()}
    for name, values in study.arrays().items():
        if values.ndim == 3:
            columns |= {f"{name}_{axis}": values[..., k].reshape(-1) for k, axis in enumerate(AXES)}
        else:
            columns[name] = values.reshape(-1)
    columns["status"] = np.tile(study.status, len(study.points))
    return pandas.DataFrame(columns)


def to_xarray(study: Tabulated) -> Any:
    """Dataset with named dimensions; see `AccuracyStudy.to_xarray`."""
    xarray = imported("xarray", "to_xarray")
    data: dict[str, Any] = {name: (DIMS[values.ndim], values) for name, values in study.arrays().items()}
    data["status"] = (("pose",), study.status)
    coords: dict[str, Any] = {
        "point": list(study.points), "pose": np.arange(len(study.status)), "axis": list(AXES),
    }  # fmt: skip
    coords |= {name: (("pose",), values) for name, values in study.drives.items()}
    data["sample_displacement"] = (("sample", "point", "pose", "axis"), study.propagation.samples)
    shares = [study.contributors[point] for point in study.points]
    coords["contributor"] = list(shares[0].names)
    shape = (len(shares), len(study.status), -1)
    for name, part in (("worst_case_share", "worst"), ("variance_share", "of_variance")):
        stacked = np.stack([getattr(each, part) for each in shares]).reshape(shape)
        data[name] = (("point", "pose", "contributor"), stacked)
    return xarray.Dataset(data, coords)
