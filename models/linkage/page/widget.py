"""The page of a motion as a notebook widget, whose settings can be read back in Python."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from ....framework.errors import FrameError
from ..statics.frame import FramedPoses
from ..worst_case.worst_case import WorstCase
from .data import MOST_POSES, driven
from .page import HEIGHT, PageText, page

# Prefix of the names of deviations that are clearances.
JOINT = "joint "


def widget(
    motion: FramedPoses, point: str, link: str | None, worst: WorstCase | None, text: PageText, drive: str | None
) -> Any:
    """See `Motion.widget`."""
    if len(motion.shape) == 1 and motion.shape[0] > MOST_POSES:
        raise FrameError(f"a widget of {motion.shape[0]} poses: give at most {MOST_POSES}")
    return _kind()(motion, worst, page(motion, point, link, worst, text, drive=drive))


@cache
def _kind() -> type:
    """The class of the widget, which needs anywidget."""
    try:
        import anywidget
        import traitlets
    except ModuleNotFoundError:
        raise FrameError("Motion.widget needs the extra `notebook`: pip install 'linkframe[notebook]'") from None

    class MotionWidget(anywidget.AnyWidget):
        """The page of a motion; see `Motion.widget`."""

        _esm = files(__package__).joinpath("widget.js").read_text(encoding="utf-8")
        page = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int(HEIGHT).tag(sync=True)
        pose = traitlets.Int().tag(sync=True)
        load = traitlets.Float(1.0).tag(sync=True)
        factors = traitlets.List(traitlets.Float()).tag(sync=True)
        numbers = traitlets.Dict().tag(sync=True)

        def __init__(self, motion: FramedPoses, worst: WorstCase | None, text: str) -> None:
            redundant = worst is None or worst.position.stress is not None
            self._motion, self._limits = motion, () if redundant or worst is None else worst.limits
            super().__init__(page=text, pose=_first(motion), factors=[1.0] * len(self._limits))

        @traitlets.validate("pose")
        def _a_pose(self, proposal: Any) -> int:
            count = self._motion.shape[0]
            if proposal["value"] not in range(count):
                raise traitlets.TraitError(f"pose = {proposal['value']}: give 0 to {count - 1}")
            return int(proposal["value"])

        @traitlets.validate("factors")
        def _a_factor_each(self, proposal: Any) -> list[float]:
            if len(proposal["value"]) != len(self._limits):
                raise traitlets.TraitError(
                    f"factors = {proposal['value']}: give one for each of {list(self.deviations)}"
                )
            return list(proposal["value"])

        @property
        def drives(self) -> dict[str, float]:
            """Value of each drive at the pose, radians or a length, as `Linkage.move` takes it."""
            return {name: float(driven(self._motion, name)[self.pose]) for name in self._motion.linkage.drives}

        @property
        def deviations(self) -> dict[str, float]:
            """Half width of each clearance and tolerance as set on the page, by its name there."""
            radii = (np.broadcast_to(each.radius, self._motion.shape)[self.pose] for each in self._limits)
            pairs = zip(self._limits, radii, self.factors, strict=True)
            return {each.name: float(radius) * factor for each, radius, factor in pairs}

        @property
        def clearances(self) -> dict[str, float]:
            """Clearances as set on the page, by joint, for `Motion.worst_case`."""
            found = self.deviations.items()
            return {name.removeprefix(JOINT): value for name, value in found if name.startswith(JOINT)}

    return MotionWidget


def _first(motion: FramedPoses) -> int:
    """The pose that a page shows first: the first regular one, or else the first assembled one."""
    regular, there = (np.flatnonzero(each) for each in (motion.status == "regular", motion.is_assembled))
    return int((regular if len(regular) else there if len(there) else [0])[0])
