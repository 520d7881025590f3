"""A writer of LLVM code with loops over vectors of numbers."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import Any

from .machine_text import WIDTH

VECTOR = f"<{WIDTH} x double>"


class LoopText:
    """Lines of an LLVM function, with methods that write loads, stores and loops; subclasses write the arithmetic."""

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._names = count()
        self._block = "entry"

    def _value(self, kind: str, line: str) -> str:
        name = f"%{kind}{next(self._names)}"
        self._lines.append(f"  {name} = {line}")
        return name

    def _int(self, operation: str, a: str, b: str) -> str:
        return self._value("n", f"{operation} i64 {a}, {b}")

    def _vector(self, line: str) -> str:
        return self._value("v", line)

    def _two(self, operation: str, a: str, b: str) -> str:
        """Write an operation on two vectors; the name of the result."""
        return self._vector(f"{operation} {VECTOR} {a}, {b}")

    def _pointer(self, at: str) -> str:
        """Write the load of a pointer from the table; its name."""
        return self._value("p", f"load ptr, ptr {self._value('p', f'getelementptr i64, ptr %table, i64 {at}')}")

    def _place(self, base: str, at: str) -> str:
        return self._value("p", f"getelementptr {VECTOR}, ptr {base}, i64 {at}")

    def _load(self, base: str, at: str) -> str:
        return self._vector(f"load {VECTOR}, ptr {self._place(base, at)}, align 8")

    def _store(self, base: str, at: str, value: str) -> None:
        self._lines.append(f"  store {VECTOR} {value}, ptr {self._place(base, at)}, align 8")

    def _loop(self, start: str, stop: str, body: Callable[[str], Any]) -> None:
        label, number, then = self._head(start)
        self._lines.append(f"  br i1 {self._less(number, stop)}, label %{label}.body, label %{label}.done")
        self._body(label)
        body(number)
        self._end(label, number, then)

    def _carried(
        self, start: str, stop: str, values: list[str], body: Callable[[str, list[str]], list[str]]
    ) -> list[str]:
        """Write a loop that carries values from one iteration to the next; the names of the final values."""
        before, label = self._block, f"loop{next(self._names)}"
        _, number, then = self._head(start, label)
        at = len(self._lines)
        self._lines += [""] * len(values)
        self._lines.append(f"  br i1 {self._less(number, stop)}, label %{label}.body, label %{label}.done")
        self._body(label)
        names = [f"%{label}.value{k}" for k in range(len(values))]
        for k, (value, found) in enumerate(zip(values, body(number, names), strict=True)):
            self._lines[at + k] = f"  {names[k]} = phi {VECTOR} [{value}, %{before}], [{found}, %{label}.end]"
        self._end(label, number, then)
        return names

    def _head(self, start: str, label: str = "") -> tuple[str, str, str]:
        label = label or f"loop{next(self._names)}"
        number, then = f"%{label}.number", f"%{label}.next"
        self._lines += [
            f"  br label %{label}",
            f"{label}:",
            f"  {number} = phi i64 [{start}, %{self._block}], [{then}, %{label}.end]",
        ]
        return label, number, then

    def _less(self, number: str, stop: str) -> str:
        return self._value("b", f"icmp slt i64 {number}, {stop}")

    def _body(self, label: str) -> None:
        self._lines.append(f"{label}.body:")
        self._block = f"{label}.body"

    def _end(self, label: str, number: str, then: str) -> None:
        self._lines += [
            f"  br label %{label}.end",
            f"{label}.end:",
            f"  {then} = add i64 {number}, 1",
            f"  br label %{label}",
            f"{label}.done:",
        ]
        self._block = f"{label}.done"
