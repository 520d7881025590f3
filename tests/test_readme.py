"""README's Python runs, in order, as a reader would type it; its commands and links exist."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]
README = (TOP / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)


def test_python_blocks_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    space: dict[str, object] = {}
    for block in blocks("python"):
        exec(compile(block, "README.md", "exec"), space)
    assert capsys.readouterr().out.startswith("(36, 3)\n")


def test_first_linkage_is_short() -> None:
    assert sum(bool(line.strip()) for line in blocks("python")[0].splitlines()) <= 15


def test_commands_are_one_line_each_and_make_their_own_environment() -> None:
    job, tests = (block.strip() for block in blocks("sh"))
    for command in (job, tests):
        assert "\n" not in command
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install ")
    scripts = tomllib.loads((TOP / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]
    assert set(scripts) == {"linkframe"}
    assert job.endswith("&& .venv/bin/linkframe four-bar --out results")
    assert tests.endswith("&& .venv/bin/pytest -n auto --dist worksteal")


@pytest.mark.parametrize("target", sorted(set(re.findall(r"\]\(([^)#]+)\)", README))))
def test_links_lead_somewhere(target: str) -> None:
    assert target.startswith("https://") or (TOP / target).exists()
