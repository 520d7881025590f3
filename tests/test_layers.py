"""Imports go one way: no circles, and in framework from later layers to earlier ones. Those for type checkers alone
count as well, and those of modules that are loaded when first used. None of an own module stands inside a function."""

from __future__ import annotations

import ast
import re
from fnmatch import fnmatch
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from reference.statements import statements

TOP = Path(__file__).parents[1]
WITHOUT_CIRCLES = ("framework", "elements", "models")

# The layers of framework, each of which may import from itself and from those before. A file that is named stands where
# it is named; the others of its folder stand where the folder is.
LAYERS = {
    "numbers, names, errors": (
        "cache checked errors interrupts optional clock garbage owner states batch entries arm rotation names renamed "
        "dofs provenance continuation lazily listing orientation shape_rules member_law structure/parts elementwise ldl"
    ),
    "recorded calculations": "program/*",
    "loads": "added_forms loads",
    "members in scikit-fem": "scikit_fem/*",
    "elements, and how they are examined": (
        "clearances/contact section_law stacking member_forms protocol joint_protocol composed formed examined "
        "examination joint_examination"
    ),
    "description": "described/* description editing meshes/* bulk",
    "structure": "structure/*",
    "elimination": "batched/* structure/assembly",
    "linear algebra": "solvers/*",
    "plan": (
        "batched/unloaded batched/entry_program batched/entry_recording batched/batch_program batched/batch_recording "
        "batched/medium_program batched/trailing_program "
        "batched/plan structure/matrices"
    ),
    "equations in extended precision": "error_bounds/*",
    "sparse solution": (
        "solvers/freedom solvers/refinement solvers/stiffness solvers/sparse solvers/stacked "
        "solvers/stacked_loads solvers/stacked_pass solvers/stacked_refinement solvers/refined_values "
        "solvers/spring_residual solvers/deformation_table factor_cache"
    ),
    "status": "results/dense results/spectrum results/sparse_spectrum results/conditioning results/status",
    "broadcasting solution": "batched/broadcast",
    "what can move": (
        "error_bounds/resolved results/reached results/constrained results/constrained_batch "
        "results/constrained_by_springs results/motions_across results/consistent_mechanisms results/singular"
    ),
    "linear solution, as others see it": "results/linear",
    "files and figures": "results/by_name results/base results/tabulated paraview/* graphics/* results/saved",
    "results": "results/*",
    "clearances": "clearances/*",
    "bounds": "error_bounds/bounds error_bounds/sensitivity",
    "stability of linear solutions": "results/under_load results/stability results/validity",
    "large displacement": "large/*",
    "linear solution": "linear/* explain solution results/buckling",
    "members and matrices for scikit-fem": "basis matrices",
    "frame": "frame",
    "pictures": "pictures/* view",
    "public names": "__init__ */__init__",
}

# The layers of models, likewise.
ROOMS = {
    "plane, samples, statistics": (
        "clearance planar newton_euler intervals histograms convergence distributions given_distributions "
        "given_deviations quantiles moments normality sampling spread propagation/* sensitivity failure/* fits/* "
        "fuzzy/* measured/*"
    ),
    "what jobs share": "job/*",
    "linkage": "linkage/*",
    "four-bar": "four_bar/*",
    "jobs": "linkage/job/* paper/*",
    "command line": "command_line",
    "public names": "__init__ linkage/__init__ linkage/files/__init__ four_bar/__init__ package/*",
}

Graph = dict[str, set[str]]


def modules(top: Path, *folders: str) -> dict[str, Path]:
    """Files by name, such as ``framework/solvers/graph``."""
    found = [path for folder in folders for path in sorted((top / folder).rglob("*.py"))]
    return {path.relative_to(top).with_suffix("").as_posix(): path for path in found}


@cache
def imports(here: tuple[str, ...], text: str) -> list[tuple[str, ...]]:
    """What a file in a folder imports, each as a module of that name or, where there is none, the one that holds it."""
    found: list[tuple[str, ...]] = []
    for node in statements(text):
        if isinstance(node, ast.Import):
            found += [(alias.name.removeprefix("linkframe.").replace(".", "/"),) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            start = here[: len(here) - node.level + 1] if node.level else ()
            rest = (node.module or "").removeprefix("linkframe.").split(".") if node.module else []
            base = "/".join([*start, *rest])
            found += [(f"{base}/{alias.name}", base) for alias in node.names]
    return found


def graph(top: Path, *folders: str) -> Graph:
    """By file the files that it imports."""
    known = modules(top, *folders)
    out: Graph = {name: set() for name in known}
    for name, path in known.items():
        for candidates in imports(path.relative_to(top).parent.parts, path.read_text(encoding="utf-8")):
            files = [file for each in candidates for file in (each, f"{each}/__init__") if file in known]
            out[name].update(files[:1])
        out[name].discard(name)
    return out


def circle(arrows: Graph) -> str:
    """A circle of imports in words; empty where there is none."""
    try:
        TopologicalSorter(arrows).prepare()
    except CycleError as error:
        return " is imported by ".join(error.args[1])
    return ""


def layer(name: str, layers: dict[str, str] = LAYERS) -> int:
    """Number of the layer of a file of framework, or of another folder."""
    kinds = [(number, kind) for number, kinds in enumerate(layers.values()) for kind in kinds.split()]
    named = [number for number, kind in kinds if kind == name]
    found = named or [number for number, kind in reversed(kinds) if "*" in kind and fnmatch(name, kind)]
    assert found, f"{name}.py stands in no layer: name it in LAYERS or ROOMS"
    return found[0]


@pytest.mark.parametrize("folder", WITHOUT_CIRCLES)
def test_there_are_no_circles(folder: str) -> None:
    assert not circle(graph(TOP, folder))


@pytest.mark.parametrize(("folder", "layers"), [("framework", LAYERS), ("models", ROOMS)])
def test_imports_go_to_earlier_layers(folder: str, layers: dict[str, str]) -> None:
    """The layers are not for show: each holds a file."""
    arrows = graph(TOP, folder)
    place = {name: layer(name.removeprefix(f"{folder}/"), layers) for name in arrows}
    assert set(place.values()) == set(range(len(layers)))
    names = list(layers)
    wrong = [
        f"{name} ({names[place[name]]}) imports {other} ({names[place[other]]})"
        for name, others in arrows.items()
        for other in sorted(others)
        if place[other] > place[name]
    ]
    assert not wrong


def inside_functions(text: str) -> set[str]:
    """Imports of the project's own modules inside functions of a file."""
    functions = [node for node in statements(text) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    inside = [node for function in functions for node in statements(function)]
    own = [node for node in inside if isinstance(node, ast.Import | ast.ImportFrom) and is_own(node)]
    return {ast.unparse(node) for node in own}


def is_own(node: ast.Import | ast.ImportFrom) -> bool:
    """Whether the project's own modules are imported."""
    if isinstance(node, ast.ImportFrom):
        return node.level > 0 or (node.module or "").split(".")[0] == "linkframe"
    return any(alias.name.split(".")[0] == "linkframe" for alias in node.names)


def test_no_own_module_is_imported_inside_a_function() -> None:
    """What is to be loaded later is a module among those of its folder's `loaded_later`, imported at the top."""
    texts = {name: path.read_text(encoding="utf-8") for name, path in modules(TOP, *WITHOUT_CIRCLES).items()}
    suspected = {
        name: text
        for name, text in texts.items()
        if re.search(r"^\s+(from \.|from linkframe|import linkframe)", text, re.MULTILINE)
    }
    assert not {name: inside for name, text in suspected.items() if (inside := inside_functions(text))}
    # nor by name, but where packages are made, and where what is imported is not of the project
    by_name = {name for name, text in texts.items() if "import_module" in text or "__import__" in text}
    assert by_name == {"framework/lazily", "framework/optional", "framework/added_forms", "models/package/__init__"}


@pytest.mark.parametrize(
    "own", ["from . import low", "from ..part.low import low", "import linkframe.part", "from linkframe import part"]
)
def test_import_inside_a_function_would_be_found(own: str) -> None:
    assert inside_functions(f"def f():\n    if True:\n        {own}\n    import numpy") == {own}
    assert inside_functions(f"class A:\n    async def f(self):\n        def g():\n            {own}") == {own}
    assert not inside_functions(f"if TYPE_CHECKING:\n    {own}\n\ndef f():\n    import numpy")


def test_what_is_loaded_later_is_there_and_imported_as_a_module() -> None:
    """A module that a folder lists is one of its files, and some file imports it by the form that puts off its load."""
    known = modules(TOP, *WITHOUT_CIRCLES)
    listed: set[str] = set()
    for name, path in known.items():
        if name.endswith("/__init__"):
            listed |= {f"{name.removesuffix('__init__')}{each}" for each in later(path.read_text(encoding="utf-8"))}
    assert {"framework/solution", "framework/results/modes", "models/command_line"} <= listed <= set(known)
    as_modules = {
        candidates[0]
        for path in known.values()
        for candidates in imports(path.relative_to(TOP).parent.parts, path.read_text(encoding="utf-8"))
    }
    assert listed <= as_modules


def later(text: str) -> list[str]:
    """The modules that a package loads when they are first used: those of its call of `loaded_later`."""
    calls = [node.value for node in statements(text) if isinstance(node, ast.Assign)]
    words = [word for call in calls if isinstance(call, ast.Call) for word in call.keywords]
    return [each for word in words if word.arg == "modules" for each in ast.literal_eval(word.value)]


def test_imports_are_seen() -> None:
    arrows = graph(TOP, *WITHOUT_CIRCLES)
    assert {"framework/solution", "framework/large/solution", "framework/bulk"} <= arrows["framework/frame"]
    assert (
        "framework/scikit_fem/integrals" in arrows["framework/member_forms"]
    )  # a module that is loaded when first used
    assert "framework/results/dense" in arrows["framework/results/modes"]  # from . import dense
    assert "framework/protocol" in arrows["elements/beam"]
    assert "framework/frame" in arrows["framework/__init__"]


@pytest.mark.parametrize(
    "back",
    [
        "from .low import low",
        "import linkframe.part.low",
        "from linkframe.part import low",
        "from . import low",
        "def f():\n    from . import low",
        "if TYPE_CHECKING:\n    from ..part.low import low",
        "from . import low as other",
    ],
)
def test_circle_would_be_found(tmp_path: Path, back: str) -> None:
    (tmp_path / "part").mkdir()
    for name, text in {"__init__": "from .high import high", "low": "from .high import *", "high": ""}.items():
        (tmp_path / "part" / f"{name}.py").write_text(text)
    assert not circle(graph(tmp_path, "part"))
    (tmp_path / "part" / "high.py").write_text(back)
    assert {"part/low", "part/high"} <= set(circle(graph(tmp_path, "part")).split(" is imported by "))


def test_named_files_stand_where_they_are_named() -> None:
    names = list(LAYERS)
    assert names[layer("solvers/sparse")] == "sparse solution"
    assert names[layer("solvers/lu")] == "linear algebra"
    with pytest.raises(AssertionError, match=r"else\.py stands in no layer"):
        layer("else")
