"""Springs and loads of equal batch shape are taken out of a batch together, however many there are."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.solvers import coupling, evaluation

BEAM = Beam(Section(A=1e-4, Iy=1e-9, Iz=2e-9, J=2e-9), Material(E=2e11, nu=0.25))
SCALES = np.linspace(1.0, 2.0, 12).reshape(4, 3)


def jointed(links: int, entry: tuple[int, int] | None = None) -> Frame:
    """A clamped chain of links of 0.1 m; its joints vary over both axes of a batch, over one or over none."""

    def at(values: np.ndarray) -> np.ndarray:
        return values if entry is None else np.broadcast_to(values, (4, 3, *values.shape[2:]))[entry]

    frame, springs = Frame(), np.array([1e9, 2e9, 1e9, 1e5, 2e5, 3e4])
    for k in range(links):
        frame.node(f"{k} start", (0.1 * k, 0.0, 0.0))
        frame.node(f"{k} end", (0.1 * (k + 1), 0.0, 0.0))
        frame.add(f"link {k}", BEAM, f"{k} start", f"{k} end")
        if k:
            scale = (SCALES, SCALES[:1], SCALES[:, :1], np.ones((1, 1)))[k % 4]
            frame.add(f"joint {k}", Joint(at(scale[..., None] * springs)), f"{k - 1} end", f"{k} start")
        frame.load(f"{k} end", fy=at(SCALES) * k, fz=1.0)
    frame.fix("0 start")
    return frame


@pytest.mark.parametrize("room", [coupling._STACKED, 0])
def test_each_entry_as_alone(room: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coupling, "_STACKED", room)
    whole = jointed(9).solve("banded")
    for entry in ((0, 0), (2, 1), (3, 2)):
        alone = jointed(9, entry).solve("banded")
        expected = alone.displacement("8 end")
        assert np.abs(whole.displacement("8 end")[entry] - expected).max() < 1e-14 * np.abs(expected).max()


def test_numbers_are_taken_out_once_for_all_springs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three times as many joints take no more calls."""
    times = []

    def counted(*given: object) -> object:
        times[-1] += 1
        return picked(*given)

    picked = evaluation.picked
    monkeypatch.setattr(evaluation, "picked", counted)
    for links in (9, 27):
        times.append(0)
        jointed(links).solve("banded").displacement("8 end")
    assert times[0] == times[1]
