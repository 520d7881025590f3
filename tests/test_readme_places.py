"""The files and folders that README names when it tells how the parts lie are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]
PARTS = (TOP / "README.md").read_text(encoding="utf-8").split("## How the parts lie")[1].split("\n## ")[0]
NAMED = sorted(set(re.findall(r"`([\w/]+(?:\.py|/))`", PARTS)))


@pytest.mark.parametrize("name", NAMED)
def test_what_is_named_is_there(name: str) -> None:
    folders = ("framework", "elements", "models", "tests", "models/linkage")
    assert any((TOP / folder / name).exists() for folder in (".", *folders)), f"README names {name}"


def test_places_are_seen() -> None:
    assert {"framework/protocol.py", "kinematics/", "solvers/method.py"} <= set(NAMED)
