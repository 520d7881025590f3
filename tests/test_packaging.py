"""What is installed is what lies in the folders, and costs no more imports than it must."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from importlib.metadata import entry_points, requires, version
from importlib.resources import files
from pathlib import Path

import pytest
from reference.statements import statements

TOP = Path(__file__).parents[1]
FOLDERS = ("framework", "elements", "models")
HEAVY = {"pyvista", "matplotlib", "vtk", "vtkmodules", "meshio", "tqdm", "llvmlite", "numba"}
PROJECT = tomllib.loads((TOP / "pyproject.toml").read_text(encoding="utf-8"))


def test_every_folder_with_code_is_packaged() -> None:
    found = {init.parent.relative_to(TOP) for folder in FOLDERS for init in (TOP / folder).rglob("__init__.py")}
    places = PROJECT["tool"]["setuptools"]["package-dir"]
    elsewhere = {Path(place): name for name, place in places.items()}
    listed = PROJECT["tool"]["setuptools"]["packages"]
    assert {elsewhere.get(path, f"linkframe.{'.'.join(path.parts)}") for path in found} == set(listed)
    assert len(listed) == len(set(listed))


def test_every_module_lies_in_a_package() -> None:
    for folder in FOLDERS:
        for module in (TOP / folder).rglob("*.py"):
            assert (module.parent / "__init__.py").exists(), f"{module.relative_to(TOP)} would not be installed"


@pytest.mark.parametrize("package", ["linkframe", *(f"linkframe.{folder}" for folder in FOLDERS)])
def test_types_are_announced_to_type_checkers(package: str) -> None:
    assert files(package).joinpath("py.typed").is_file()


def test_printed_table_is_installed() -> None:
    assert files("linkframe.models.paper").joinpath("data/table1.csv").is_file()


def test_one_version_everywhere() -> None:
    stated = PROJECT["project"]["version"]
    citation = re.search(r"^version: (.+)$", (TOP / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert version("linkframe") == stated
    assert citation is not None
    assert citation[1] == stated


def test_command_is_installed() -> None:
    (command,) = entry_points(group="console_scripts", name="linkframe")
    from linkframe.__main__ import main

    assert command.load() is main


def test_every_dependency_has_a_lower_bound() -> None:
    needed = requires("linkframe") or []
    assert {re.split(r"[^\w-]", need)[0] for need in needed if "extra" not in need} == {
        "scikit-fem", "numpy", "scipy", "meshio", "pyvista", "matplotlib", "tqdm",
    }  # fmt: skip
    assert all(">=" in need for need in needed)


@pytest.mark.parametrize(
    ("module", "unwanted"),
    [
        ("linkframe.framework", {*HEAVY, "linkframe.elements"}),
        ("linkframe.elements", {*HEAVY, "linkframe.models"}),
        ("linkframe.models", HEAVY),
    ],
)
def test_import_loads_no_more_than_it_must(module: str, unwanted: set[str]) -> None:
    program = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert module in loaded
    assert not unwanted.intersection(loaded)


@pytest.mark.parametrize(("lower", "higher"), [("framework", {"elements", "models"}), ("elements", {"models"})])
def test_imports_point_down(lower: str, higher: set[str]) -> None:
    for module in (TOP / lower).rglob("*.py"):
        for node in statements(module.read_text(encoding="utf-8")):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            source = f"{node.module or ''}." if isinstance(node, ast.ImportFrom) else ""
            parts = {part for name in names for part in f"{source}{name}".split(".")}
            assert not higher & parts, f"{module.relative_to(TOP)} imports {higher & parts}"
