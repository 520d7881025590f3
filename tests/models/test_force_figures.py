"""Forces of joints and drives over a drive: what the axes say."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models.job.force_figures import Over, draw_reactions


def test_where_no_pose_has_forces_the_figure_says_so() -> None:
    """As at dead points alone; empty axes with names of curves are read as forces of zero."""
    nothing = np.full(3, np.nan)
    left, right = draw_reactions(
        Over(np.arange(3.0), "θ [°]", True), {"B": nothing, "D": nothing}, {"A": ("N m", nothing)}
    ).axes
    for axes, what in ((left, "joint force"), (right, "drive torque")):
        assert axes.get_title(loc="left") == f"no pose has a finite {what}"
        assert not axes.axison
        assert axes.get_legend() is None


@pytest.mark.parametrize(
    ("units", "label", "named"),
    [
        ({"A": "N m"}, "drive torque [N m]", ["A"]),
        ({"A": "N m", "B": "N m"}, "drive torque [N m]", ["A", "B"]),
        ({"s": "N"}, "drive force [N]", ["s"]),
        ({"A": "N m", "s": "N"}, "drive force or torque", ["A [N m]", "s [N]"]),
    ],
)
def test_the_axis_of_drives_names_their_unit(units: dict[str, str], label: str, named: list[str]) -> None:
    """Once for all drives of one kind, else at each of them."""
    angle = np.linspace(0.0, 90.0, 4)
    pushes = {drive: (unit, k + np.sin(angle)) for k, (drive, unit) in enumerate(units.items())}
    _, right = draw_reactions(Over(angle, "θ [°]", True), {"B": np.cos(angle) + 2.0}, pushes).axes
    assert right.get_ylabel() == label
    legend = right.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == named
