"""The public face is documented: every name, every parameter; and its examples run."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from dataclasses import is_dataclass
from types import ModuleType

import pytest

PACKAGES = ("linkframe.framework", "linkframe.elements", "linkframe.models")


def modules() -> list[str]:
    found = ["linkframe"]
    for name in PACKAGES:
        package = importlib.import_module(name)
        found.append(name)
        found.extend(info.name for info in pkgutil.walk_packages(package.__path__, f"{name}."))
    return found


def public() -> Iterator[tuple[str, object]]:
    """Functions, classes and their methods that a user can reach by a public name."""
    for name in PACKAGES:
        package = importlib.import_module(name)
        for public_name in package.__all__:
            thing = getattr(package, public_name)
            if isinstance(thing, ModuleType):
                continue
            yield f"{name}.{public_name}", thing
            if inspect.isclass(thing):
                yield from methods(f"{name}.{public_name}", thing)


def methods(prefix: str, cls: type) -> Iterator[tuple[str, object]]:
    own = [base for base in reversed(cls.__mro__) if base.__module__.startswith("linkframe.")]
    for name, member in {name: member for base in own for name, member in vars(base).items()}.items():
        if name.startswith("_"):
            continue
        function = getattr(member, "__func__", None) or getattr(member, "fget", None) or getattr(member, "func", member)
        if inspect.isfunction(function):
            yield f"{prefix}.{name}", function


def documented(doc: str) -> set[str]:
    """Names under the headings Parameters, Other Parameters and Attributes of a numpydoc docstring."""
    names: set[str] = set()
    sections = re.split(r"^([A-Z][\w ]+)\n-{3,}\n", inspect.cleandoc(doc), flags=re.MULTILINE)
    for heading, body in zip(sections[1::2], sections[2::2], strict=True):
        if heading in {"Parameters", "Other Parameters", "Attributes"}:
            for line in body.splitlines():
                if line and not line[0].isspace():
                    names |= {name.strip().lstrip("*") for name in line.split(":")[0].split(",")}
    return names


def parameters(thing: object) -> list[str]:
    if inspect.isclass(thing):
        if issubclass(thing, Exception):
            return []
        if "__init__" not in vars(thing) and not is_dataclass(thing):
            return []
    signature = inspect.signature(thing)  # type: ignore[arg-type]
    return [name for name in signature.parameters if name not in {"self", "cls"} and not name.startswith("_")]


THINGS = dict(public())


def test_there_is_a_public_face() -> None:
    assert {"linkframe.framework.Frame", "linkframe.elements.Beam", "linkframe.models.FourBar"} <= set(THINGS)


@pytest.mark.parametrize("name", THINGS)
def test_docstring_names_every_parameter(name: str) -> None:
    doc = THINGS[name].__doc__
    assert doc, f"{name} has no docstring"
    assert not re.match(r"\w+\(.*\) -> ", doc), f"{name} only has a generated docstring"
    missing = [parameter for parameter in parameters(THINGS[name]) if parameter not in documented(doc)]
    assert not missing, f"docstring of {name} does not document {', '.join(missing)}"


def test_missing_parameter_would_be_found() -> None:
    def scale(value: float, factor: float) -> float:
        """Scale.

        Parameters
        ----------
        value
            What to scale.
        """
        return value * factor

    assert parameters(scale) == ["value", "factor"]
    assert documented(scale.__doc__ or "") == {"value"}


@pytest.mark.parametrize("name", modules())
def test_examples_in_docstrings_run(name: str) -> None:
    outcome = doctest.testmod(importlib.import_module(name))
    assert outcome.failed == 0
