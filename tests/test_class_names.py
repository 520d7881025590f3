"""No class name stands twice in the three folders: a name in a message or a traceback says which class is meant."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

from reference.statements import statements

TOP = Path(__file__).parents[1]


def test_no_class_name_stands_twice() -> None:
    found = defaultdict(list)
    for folder in ("framework", "elements", "models"):
        for path in sorted((TOP / folder).rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            for node in statements(text) if "class " in text else ():
                if isinstance(node, ast.ClassDef):
                    found[node.name].append(f"{path.relative_to(TOP)}:{node.lineno}")
    assert len(found) > 100
    assert not {name: places for name, places in found.items() if len(places) > 1}
