"""Numbers and titles of figures have room, however many digits they need; poses that are not there have no numbers."""

from __future__ import annotations

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from linkframe.elements import Beam, Circle, Material
from linkframe.framework.graphics.canvas import few_ticks
from linkframe.models import Linkage, plot_histogram
from pictures.test_texts_find_room import boxes

SAMPLES = -22.711 + 0.0021 * np.random.default_rng(0).normal(size=60)


def test_titles_of_histograms_end_before_the_next() -> None:
    figure, panels = plt.subplots(1, 2, figsize=(7.6, 3.4), layout="constrained")
    for axes in panels:
        plot_histogram(SAMPLES, axes, label="u", unit="mm")
    figure.canvas.draw()
    first, second = boxes([axes._left_title for axes in panels])
    assert first.x1 < second.x0
    assert second.x1 < figure.bbox.x1


def test_numbers_of_many_digits_stand_beside_each_other() -> None:
    figure, panels = plt.subplots(1, 3, figsize=(7.6, 2.4), layout="constrained")
    for axes in panels:
        axes.plot(14.25 + 1e-7 * SAMPLES, SAMPLES, "o")
        axes.set(aspect="equal", adjustable="datalim", ylabel="u of a point [mm]")
        few_ticks(axes, 5)
    figure.canvas.draw()
    for axes in panels:
        numbers = [tick.label1 for tick in axes.xaxis.get_major_ticks() if tick.label1.get_text()]
        inside = [n for n in numbers if axes.get_xlim()[0] <= n.get_position()[0] <= axes.get_xlim()[1]]
        assert all(one.x1 < other.x0 for one, other in pairwise(boxes(inside)))


def test_poses_that_are_not_assembled_have_no_rigid_position() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(2, 1), D=(2.4, 0))
    bar = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
    for link in ("AB", "BC", "CD"):
        linkage.link(link, *link, beam=bar)
    for pin, links in {"A": ("ground", "AB"), "B": ("AB", "BC"), "C": ("BC", "CD"), "D": ("CD", "ground")}.items():
        linkage.revolute(pin, *links, drive=pin == "A")
    linkage.load("C", fy=1.0)
    motion = linkage.move(A=[0.0, 3.0])
    assert motion.is_assembled.tolist() == [True, False]
    np.testing.assert_array_equal(motion.accuracy("C").rigid, motion.position("C"))
