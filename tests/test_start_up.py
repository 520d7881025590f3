"""What a short script pays for: scikit-fem and SciPy's solvers are loaded only by what needs them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ONE_BEAM = """
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import Frame
frame = Frame()
frame.add_nodes(["A", "B"], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
frame.fix("A")
frame.load("B", fy=-10.0)
solution = frame.solve()
solution.displacement("B"), solution.reaction("A"), solution.end_forces("AB"), solution.status, frame.explain()
import sys
print(*(name for name in ("skfem", "scipy.sparse", "scipy.linalg", "scipy.special", "meshio") if name in sys.modules))
"""


def test_a_description_loads_nothing_that_solves() -> None:
    """What solves is named at the top of the file with `Frame`, and loaded where a frame is first solved."""
    script = (
        ONE_BEAM.partition("solution =")[0]
        + """
import sys
for name in sys.modules:
    if name.startswith(("linkframe.framework.", "skfem", "scipy")):
        print(name.removeprefix("linkframe.framework."))
"""
    )
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True, timeout=60).stdout
    loaded = told.split()
    assert {"frame", "large", "results"} <= set(loaded)
    solving = ("solution", "basis", "matrices", "batched", "solvers", "large.", "results.", "meshes.", "skfem", "scipy")
    assert not [name for name in loaded if name.startswith(solving)]


@pytest.mark.parametrize(("more", "loaded"), [("", ""), ("frame.solve('sparse').displacement('B')", "scipy.sparse")])
def test_one_beam_loads_no_solver_of_large_frames(more: str, loaded: str) -> None:
    script = ONE_BEAM.replace("import sys\n", f"{more}\nimport sys\n")
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True, timeout=60).stdout
    assert told.split()[:1] == loaded.split()


def test_models_load_what_is_used_of_them() -> None:
    """A four-bar is no linkage yet, and nothing draws it; what is asked for comes all the same."""
    script = """
import sys
import linkframe.models
print(*(name for name in sys.modules if name.startswith("linkframe.models.")))
from linkframe.models import FourBar
FourBar().move(0.5).frame()
print(*(name for name in sys.modules if name.startswith("linkframe.models.linkage.")))
print(type(FourBar().linkage(0.5)).__module__)
"""
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True, timeout=60).stdout
    nothing, few, module = told.split("\n")[:3]
    assert not nothing
    assert not {f"linkframe.models.linkage.{name}" for name in ("linkage", "motion", "graphics.plots")} & {*few.split()}
    assert module == "linkframe.models.linkage.linkage"


def test_the_command_line_loads_nothing_that_solves() -> None:
    """Help, and the refusal of a wrong option, come before what a job would need."""
    script = """
import sys
import linkframe.models.command_line
print(*(name for name in sys.modules if name.startswith(("linkframe.framework.batched", "linkframe.framework.sol"))))
"""
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True, timeout=60).stdout
    assert not told.split()


def test_a_job_without_figures_loads_nothing_that_draws(tmp_path: Path) -> None:
    """Nor what reads meshes, fits to measurements, keeps checkpoints, or shows a bar on a terminal.

    The job does in this process what it otherwise leaves to a copy.
    """
    script = """
import sys
from linkframe.models.command_line import main
from linkframe.models.job import beside
beside.copies = lambda: False
main()
for name in sys.modules:
    if name.startswith(("linkframe.", "tqdm", "matplotlib", "scipy.")):
        print("loaded", name)
"""
    words = ["four-bar", "--poses", "30", "30", "1", "--samples", "2", "--figures", "none", "--out", str(tmp_path)]
    told = subprocess.run(
        [sys.executable, "-c", script, *words], capture_output=True, check=True, text=True, timeout=100
    ).stdout
    loaded = {line.removeprefix("loaded ") for line in told.splitlines() if line.startswith("loaded ")}
    assert "linkframe.models.paper.job" in loaded
    idle = {
        "tqdm", "matplotlib", "scipy.stats", "linkframe.elements.tube", "linkframe.elements.spring",
        "linkframe.framework.graphics.canvas", "linkframe.framework.graphics.plots", "linkframe.framework.meshes.lines",
        "linkframe.models.job.figures", "linkframe.models.measured.calibration", "linkframe.models.propagation.chunk",
        "linkframe.models.propagation.checkpoint", "linkframe.models.propagation.packed",
        "linkframe.framework.clearances.contact_search",
    }  # fmt: skip
    assert not idle & loaded


@pytest.mark.parametrize(
    ("program", "idle"),
    [
        ("from linkframe.models import Linkage", "scipy.spatial"),
        ("import linkframe.framework.pictures.drawing_process", "linkframe.framework.solution"),
    ],
)
def test_neither_linkages_nor_the_process_that_draws_load_what_solves_other_tasks(program: str, idle: str) -> None:
    script = f"{program}\nimport sys\nprint({idle!r} in sys.modules)"
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True, timeout=60).stdout
    assert told.split() == ["False"]


@pytest.mark.parametrize("alone", [True, False])
def test_garbage_collection_leaves_out_what_a_process_has_loaded(alone: bool) -> None:
    """If the process runs nothing but a job; it goes on in any case."""
    script = f"""
import gc
from linkframe.framework.garbage import lasting
with lasting(alone={alone}):
    print(gc.isenabled())
print(gc.isenabled(), gc.get_freeze_count() > 0)
"""
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True, timeout=60).stdout
    assert told.split() == ["False", "True", str(alone)]


def test_a_job_searches_for_garbage_among_its_own_objects(tmp_path: Path) -> None:
    """As a command; called by another program it excludes none of that one's objects."""
    script = """
import gc
import sys
from linkframe.models import command_line
from linkframe.models.job import run
seen = []
run.run, begin = lambda *given: (seen.append(gc.get_freeze_count() > 10_000), begin(*given)), run.run
command_line.main(sys.argv[1:] if sys.argv.pop(1) == "called" else None)
print(seen)
"""
    words = ["four-bar", "--poses", "30", "30", "1", "--samples", "2", "--figures", "none", "--out", str(tmp_path)]
    for how, frozen in (("called", False), ("command", True)):
        command = [sys.executable, "-c", script, how, *words]
        told = subprocess.run(command, capture_output=True, check=True, text=True, timeout=100).stdout
        assert told.splitlines()[-1] == f"[{frozen}]"
