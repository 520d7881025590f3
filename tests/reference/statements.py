"""Statements of a source file, or of a part of one."""

from __future__ import annotations

import ast
from collections.abc import Iterator


def statements(of: str | ast.AST) -> Iterator[ast.AST]:
    """A module, by its text, or a statement, and all that stand in it. Expressions, most of a tree, are passed over."""
    left: list[ast.AST] = [ast.parse(of) if isinstance(of, str) else of]
    while left:
        node = left.pop()
        yield node
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            inside = getattr(node, part, ())
            if isinstance(inside, list):
                left += inside
