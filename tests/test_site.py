"""The Python of the documentation site runs page by page, as a reader would type it; every public name is there."""

from __future__ import annotations

import re
import shlex
import textwrap
from collections import Counter
from pathlib import Path

import linkframe
import matplotlib.pyplot as plt
import pytest
from linkframe.framework import SolutionState
from linkframe.models.command_line import main

SITE = Path(__file__).parents[1] / "examples" / "site"
MADE = {"generated", "templates"}
PAGES = sorted(page for page in SITE.rglob("*.rst") if not MADE.intersection(page.parts))
BLOCK = re.compile(r"^\.\. (run|shell)::\n((?:   .*\n|\n)+)", flags=re.MULTILINE)
TREE = re.compile(r"^\.\. toctree::\n((?:   .*\n|\n)+)", flags=re.MULTILINE)
TERM = re.compile(r"\*\*([a-z ]+)\*\*:")
ENTRY = re.compile(r"^   (?:.*<)?(\w[\w/]*)>?$", flags=re.MULTILINE)


def blocks(page: Path) -> list[tuple[str, str]]:
    """Blocks that are run when the site is built: whether Python (run) or commands (shell), and their text."""
    return [(kind, textwrap.dedent(block)) for kind, block in BLOCK.findall(page.read_text(encoding="utf-8"))]


@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")  # pages read singular poses to show them
@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page)], ids=lambda page: page.stem)
def test_blocks_run(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each status that a page explains is that of an example on it."""
    monkeypatch.chdir(tmp_path)
    space: dict[str, object] = {}
    for number, (kind, block) in enumerate(blocks(page), 1):
        if kind == "run":
            exec(compile(block, f"{page.name}, block {number}", "exec"), space)
        else:
            assert not any(main(shlex.split(line)[1:]) for line in block.strip().splitlines())
        plt.close("all")
    printed = capsys.readouterr().out
    told = {state.text for state in SolutionState} & set(TERM.findall(page.read_text(encoding="utf-8")))
    assert not [text for text in told if not re.search(rf"(^|'){text}('| |$)", printed, flags=re.MULTILINE)]


def test_every_public_name_has_one_place_among_the_tasks() -> None:
    listed = re.findall(r"^   ([A-Za-z_]+)$", (SITE / "api.rst").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert Counter(listed) == Counter(linkframe.__all__)


def test_every_page_is_in_a_list() -> None:
    listed = {SITE / "index.rst"}
    for page in PAGES:
        for tree in TREE.findall(page.read_text(encoding="utf-8")):
            listed |= {
                page.parent / f"{name}.rst"
                for name in re.findall(r"^   (?:.*<)?(\w[\w/]*)>?$", tree, flags=re.MULTILINE)
            }
    assert set(PAGES) <= listed


def test_no_block_of_python_is_only_shown() -> None:
    assert not [page.name for page in PAGES if "code-block:: python" in page.read_text(encoding="utf-8")]
