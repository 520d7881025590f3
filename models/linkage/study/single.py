"""Check that a linkage has no batch."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription
from ..files.source import Source
from ..files.toml import Path


def check_single(source: Source, linkage: LinkageDescription, path: Path) -> None:
    """Refuse a linkage with a batch: the batch of a job or study is made of poses and samples of one linkage.

    Raises
    ------
    FrameError
        If a number of the linkage is an array; the message names `path`.
    """
    links, joints = linkage.links.values(), linkage.joints.values()
    shapes: dict[str, tuple[int, ...]] = {"points or joints": linkage.shape, "gravity": linkage.weight.shape[:-1]}
    for link in links:
        given = {"mass": (link.mass, 0), "centre": (link.centre, 1), "inertia": (link.inertia, 2)}
        shapes |= {f"{key} of {link.name}": _batch(*value) for key, value in given.items()}
        shapes |= {f"beam {' '.join(pair)}": beam.shape for pair, beam in link.beams.items()}
    for pair in joints:
        shapes[f"stiffness of {pair.name}"] = _batch(pair.stiffness, 1)
        shapes[f"clearance of {pair.name}"] = _batch(pair.clearance, 0)
    for index, spring in enumerate(linkage.springs):
        shapes |= {f"spring {index}": np.shape(spring.stiffness + spring.length + spring.damping)}
    shapes |= {f"load {index}": load.value.shape[:-1] for index, load in enumerate(linkage.loads)}
    for what, shape in shapes.items():
        if shape:
            source.fail(
                path,
                f"{what}: a list of shape {shape} stands where one number is needed; give it, and what varies "
                "as a tolerance",
            )


def _batch(value: Array | None, trailing: int) -> tuple[int, ...]:
    return () if value is None else value.shape[: value.ndim - trailing]
