"""The Python of the documentation site runs page by page, as a reader would type it; every public name is there."""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from pathlib import Path

import linkframe
import matplotlib.pyplot as plt
import pytest

SITE = Path(__file__).parents[1] / "examples" / "site"
MADE = {"generated", "templates"}
PAGES = sorted(page for page in SITE.rglob("*.rst") if not MADE.intersection(page.parts))
BLOCK = re.compile(r"^\.\. run::\n((?:   .*\n|\n)+)", flags=re.MULTILINE)
TREE = re.compile(r"^\.\. toctree::\n((?:   .*\n|\n)+)", flags=re.MULTILINE)
ENTRY = re.compile(r"^   (?:.*<)?(\w[\w/]*)>?$", flags=re.MULTILINE)


def blocks(page: Path) -> list[str]:
    """Blocks of Python that are run when the site is built."""
    return [textwrap.dedent(block) for block in BLOCK.findall(page.read_text(encoding="utf-8"))]


@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")  # pages read singular poses to show them
@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page)], ids=lambda page: page.stem)
def test_blocks_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space: dict[str, object] = {}
    for number, block in enumerate(blocks(page), 1):
        exec(compile(block, f"{page.name}, block {number}", "exec"), space)
    plt.close("all")


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
