"""Which figures a job draws, and what it need not load for those that it does not."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework.graphics.style import figure
from linkframe.framework.pictures import drawing_process
from linkframe.framework.pictures.drawing import Drawing
from linkframe.framework.pictures.drawing_process import Artist
from linkframe.framework.pictures.rendering import RenderingError
from linkframe.models.command_line import main
from linkframe.models.job.run import _write
from linkframe.models.sampling import Normal
from scipy import stats

FEW = ["--poses", "30", "60", "30", "--samples", "5"]
FILE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
FIGURES = {
    "four-bar": ["figure5.png", "figure6.png", "figure7.png", "reactions.png", "figure3d.png"],
    "run": ["mechanism.png", "trajectory.png", "reactions.png", "histogram.png", "figure3d.png"],
}
HEAVY = ("matplotlib", "pyvista", "vtkmodules", "scipy.stats")
LOADED = f"""
import sys
from linkframe.models.command_line import main
from linkframe.models.job.run import _write
main(sys.argv[1:])
print([name for name in {HEAVY} if name in sys.modules])
"""


@pytest.mark.parametrize("job", [["four-bar", *FEW], ["run", str(FILE)]], ids=lambda words: words[0])
def test_figures_that_are_not_asked_for_are_not_drawn(job: list[str], tmp_path: Path) -> None:
    """Nor do those of an earlier run stay; everything else is written all the same."""
    for name in (*FIGURES[job[0]], "mine.png"):
        (tmp_path / name).write_text("earlier", encoding="utf-8")
    assert main([*job, "--figures", "none", "--out", str(tmp_path)]) == 0
    written = {path.name for path in tmp_path.iterdir()}
    assert {name for name in written if name.endswith(".png")} == {"mine.png"}
    assert {"report.md", "reactions.csv", "samples.npz", "trajectory.pvd"} <= written
    assert ".png" not in (tmp_path / "report.md").read_text(encoding="utf-8")


def test_without_figures_nothing_is_loaded_that_draws(tmp_path: Path) -> None:
    words = ["four-bar", *FEW, "--figures", "none", "--out", str(tmp_path)]
    ended = subprocess.run([sys.executable, "-c", LOADED, *words], capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines()[-1] == "[]"


def test_a_normal_distribution_has_the_bits_of_scipy() -> None:
    q = np.concatenate([[2.0**-54, 1.0 - 2.0**-53], np.random.default_rng(0).random(1000)])
    ours, theirs = Normal(2e11, 1e10), stats.norm(2e11, 1e10)
    assert ours.ppf(q).tobytes() == theirs.ppf(q).tobytes()
    np.testing.assert_allclose(ours.pdf(ours.ppf(q)), theirs.pdf(theirs.ppf(q)), rtol=1e-14)


# -- the picture in space, drawn by another process ------------------------------------------------------------------

NONE = np.zeros(0)
NOTHING = Drawing(NONE, NONE, NONE, (NONE, NONE), NONE, NONE > 0.0, NONE, (NONE, NONE), NONE, 1.0, NONE > 0.0)
TAKEN = "import sys; print('ready'); sys.stdin.buffer.read(); "


@pytest.mark.parametrize(
    ("program", "told"),
    [
        ("raise SystemExit(1)", "libegl1"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "libegl1"),
        (f"{TAKEN} raise ValueError('no room')", "ValueError: no room"),
    ],
)
def test_a_process_that_cannot_draw_is_told(
    program: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawing_process, "PROGRAM", program)
    with Artist() as artist:
        artist.draw(NOTHING, tmp_path / "here.png")
        with pytest.raises(RenderingError, match=f"^here.png was not made: .*{told}"):
            artist.wait()


def test_a_process_that_can_is_believed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing_process, "PROGRAM", TAKEN)
    with Artist() as artist:
        artist.draw(NOTHING, tmp_path / "here.png")
        artist.wait()


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("asked", [False, True])
def test_nobody_waits_for_a_picture_that_is_not_wanted_any_more(
    asked: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawing_process, "PROGRAM", "import time; time.sleep(60)")
    with Artist() as artist:
        if asked:
            artist.draw(NOTHING, tmp_path / "here.png")
        process = artist._process
        assert process is not None
    assert process.returncode == -signal.SIGKILL


def test_a_png_is_drawn_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the same bytes as by savefig, which draws it on nothing before; other forms find their layout as before."""
    from matplotlib.figure import Figure

    def drawn() -> Figure:
        made, (axes,) = figure(3.0, 2.0)
        axes.plot([0.0, 1.0], [2.0, 5.0], label="a curve")
        axes.legend()
        return made

    drawn().savefig(tmp_path / "whole.png", pil_kwargs={"compress_level": 1})
    count: list[Figure] = []
    draw = Figure.draw
    monkeypatch.setattr(Figure, "draw", lambda self, renderer: (count.append(self), draw(self, renderer))[1])
    made = drawn()
    _write(made, tmp_path / "once.png", ["png"])
    assert len(count) == 1
    assert made.get_layout_engine() is not None
    assert (tmp_path / "once.png").read_bytes() == (tmp_path / "whole.png").read_bytes()
