"""The public face is documented as numpydoc asks for it, says more than names do, and its examples run."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from enum import Enum
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from numpydoc.docscrape import get_doc_object
from numpydoc.validate import Validator, validate

PACKAGES = ("linkframe.framework", "linkframe.elements", "linkframe.models")

# Not asked of a docstring: types of what is taken and given (PR04, RT02), which the annotations tell; a list of what
# else to see (SA) and a second paragraph (ES01), where there is nothing to add; an example (EX01) but at equations
# and entry points; a summary below the quotes (GL01), which some versions
# of numpydoc want and others do not.
NOT_ASKED = re.compile("PR04|RT02|SA0.|ES01|EX01|GL01")

# Where somebody begins to read: what describes, solves and evaluates. Pictures need OpenGL, so that no example
# can draw one everywhere.
ENTRY_POINTS = {
    "Frame": "add add_form add_many add_nodes alias basis body buckling change exclude explain fix from_mesh gravity "
    "line_load load matrices modes node offset path point_load prescribe rigid set_load solve tie unload",
    "Solution": "contact displacement displacement_along distance_to_singularity end_forces error_bound forces "
    "free_motion joint_displacement joint_force nonlinearity reaction refined save sensitivity stress",
    "Linkage": "cylindrical dead_points drive drive_range fixed gravity link load mobility move planar point prismatic "
    "revolute screw spherical spring torque universal",
    "Motion": "accuracy compliance_matrix coordinate frame free_accelerations frequencies kinetic_energy position "
    "reactions save stiffness stress transmission_angle velocity",
    "FourBar": "assembles gap move singular",
    "FourBarMotion": "angle frame position reactions velocity",
}
EQUATION = re.compile(r"``[^`\n]* = (?!\[)[^`\n]*``|::\n\n +\w+ = ")
# A year, a number in the paper that the four-bar is from, or the title of a book.
SOURCE = re.compile(r"\b(18|19|20)\d\d\b|Eq\. |\*[A-Z][\w\s]+\*")


def modules() -> list[str]:
    found = ["linkframe"]
    for name in PACKAGES:
        package = importlib.import_module(name)
        found.append(name)
        found.extend(info.name for info in pkgutil.walk_packages(package.__path__, f"{name}."))
    return found


def public() -> dict[str, dict[str, tuple[Any, type | None]]]:
    """Functions and classes by public name, each with the methods and properties that no class before it has."""
    found: dict[str, dict[str, tuple[Any, type | None]]] = {}
    seen: set[int] = set()
    for package in map(importlib.import_module, PACKAGES):
        for name in package.__all__:
            thing = getattr(package, name)
            if isinstance(thing, ModuleType):
                continue
            parts = {name: (thing, None)}
            if inspect.isclass(thing):
                parts |= {f"{name}.{each}": (value, thing) for each, value in members(thing)}
            found[name] = {each: part for each, part in parts.items() if id(part[0]) not in seen}
            seen |= {id(part[0]) for part in parts.values()}
    return found


def members(cls: type) -> Iterator[tuple[str, Any]]:
    """Public methods and properties that a class has from linkframe, those of its bases included.

    One that overrides another and has no more to say has the docstring of that other.
    """
    for name in sorted({name for base in bases(cls) for name in vars(base) if not name.startswith("_")}):
        values = [vars(base)[name] for base in bases(cls) if name in vars(base)]
        value = next((each for each in values if each.__doc__), values[0])
        value = getattr(value, "__func__", value)
        if inspect.isfunction(value) or isinstance(value, (property, cached_property)):
            yield name, value


def bases(cls: type) -> list[type]:
    return [base for base in cls.__mro__ if base.__module__.split(".")[0] == "linkframe"]


def scraped(thing: object) -> Any:
    return get_doc_object(thing, config={"show_class_members": False})


THINGS = public()
EVERYTHING = {name: part for parts in THINGS.values() for name, part in parts.items()}


class Documented(Validator):  # type: ignore[misc]
    """What numpydoc sees of a public object, by the rules of this project.

    * A class that no user constructs, such as a result, has no section Parameters: what it is made with is listed under
      Attributes, private fields excepted, and further attributes may stand there.
    * The signature of an enumeration and of an exception is Python's, and that of an abstract class concerns nobody.

    Parameters
    ----------
    obj_name
        Name in `EVERYTHING`.
    """

    def __init__(self, obj_name: str) -> None:
        super().__init__(scraped(EVERYTHING[obj_name][0]))

    @property
    def signature_parameters(self) -> tuple[str, ...]:
        if inspect.isclass(self.obj) and (issubclass(self.obj, (Enum, Exception)) or inspect.isabstract(self.obj)):
            return ()
        return tuple(name for name in super().signature_parameters if not name.startswith("_"))

    @property
    def doc_all_parameters(self) -> dict[str, Any]:
        return dict(self._doc_parameters(["Parameters", "Other Parameters", "Attributes"]))

    @property
    def parameter_mismatches(self) -> list[tuple[str, str]]:
        if not inspect.isclass(self.obj):
            return list(super().parameter_mismatches)
        parameters = tuple(self._doc_parameters(["Parameters", "Other Parameters"]))
        if parameters:
            same = parameters == self.signature_parameters
            return [] if same else [("PR03", f"takes {self.signature_parameters}, documented are {parameters}")]
        missing = set(self.signature_parameters) - set(self.doc_all_parameters)
        return [("PR01", f"Attributes {missing} not documented")] if missing else []


def left_to_a_base(name: str) -> set[str]:
    """What an overriding method leaves to that of a base class, which tells it: parameters, and what it returns."""
    thing, cls = EVERYTHING[name]
    above = [] if cls is None else [vars(base).get(name.partition(".")[2]) for base in bases(cls)]
    docs = [scraped(each) for each in above if inspect.isfunction(each) and each is not thing and each.__doc__]
    return {
        code for code, section in (("PR01", "Parameters"), ("RT01", "Returns")) if any(doc[section] for doc in docs)
    }


def findings(name: str) -> list[str]:
    left = left_to_a_base(name)
    found = validate(name, validator_cls=Documented)["errors"]
    return [f"{name}: {code} {text}" for code, text in found if not NOT_ASKED.match(code) and code not in left]


def repeats(name: str, text: str) -> bool:
    """Whether a text says no more than a name: the same words, but for articles and a shape."""
    said = [word.lower() for word in re.findall(r"\w+", re.sub(r"\(.*?\)", "", text))]
    return set(said) - {"a", "an", "the", "its", "s"} <= set(name.lower().strip("*_").split("_"))


def repeated(name: str) -> list[str]:
    """What a summary, or the text of a parameter, says no more of than its name."""
    doc = Documented(name)
    given = {each: " ".join(text) for each, (_, text) in doc.doc_all_parameters.items()}
    summary = EVERYTHING[name][0].__doc__.strip().split("\n\n")[0]
    given |= {name.rpartition(".")[2]: summary}
    return [f"{name}: {each} is said to be {text!r}" for each, text in given.items() if repeats(each, text)]


def shapeless(name: str) -> list[str]:
    """Arrays that are taken or given without a word of their shape, such as (..., 3), or of where it is told."""
    doc, thing = Documented(name), EVERYTHING[name][0]
    told = {key.strip("*"): " ".join(text) for key, (_, text) in doc.doc_all_parameters.items()}
    told["return"] = " ".join(line for each in doc.returns for line in each.desc)
    function = thing
    if inspect.isclass(thing):
        function = thing.__init__
    elif not inspect.isfunction(thing):
        function = thing.fget if isinstance(thing, property) else thing.func
        told["return"] = thing.__doc__
    kinds = getattr(function, "__annotations__", {})
    arrays = [key for key, kind in kinds.items() if re.search("Array|States", str(kind)) and told.get(key)]
    return [f"{name}: {key} has no shape" for key in arrays if not re.search(r"\(|[Aa]s for ", told[key])]


@pytest.mark.parametrize("name", THINGS)
def test_docstrings_are_what_numpydoc_asks_for(name: str) -> None:
    for each in THINGS[name]:
        doc = EVERYTHING[each][0].__doc__
        assert doc, f"{each} has no docstring"
        assert not re.match(r"\w+\(.*\)( -> |$)", doc), f"{each} only has a generated docstring"
    assert not [finding for each in THINGS[name] for finding in findings(each)]


@pytest.mark.parametrize("name", THINGS)
def test_what_is_taken_and_given_is_more_than_named(name: str) -> None:
    assert not [finding for each in THINGS[name] for finding in (*repeated(each), *shapeless(each))]


def test_every_public_name_is_looked_at() -> None:
    assert set(THINGS) == set(importlib.import_module("linkframe").__all__)
    assert {"Frame.solve", "Frame.load", "Beam.mass_matrix", "Motion.accuracy", "FourBar.move"} <= set(EVERYTHING)


def scaled(load: ArrayLike, of: str = "") -> float:
    """
    Scales a load.

    Parameters
    ----------
    load
        the load
    """
    return float(np.max(load)) * len(of)


def test_what_is_missing_would_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(EVERYTHING, "scaled", (scaled, None))
    assert {finding.split()[1] for finding in findings("scaled")} == {"PR01", "PR08", "PR09", "RT01", "SS05"}
    assert repeated("scaled") == ["scaled: load is said to be 'the load'"]
    monkeypatch.setattr(scaled, "__doc__", "Scaled, (...).")
    assert repeated("scaled") == ["scaled: scaled is said to be 'Scaled, (...).'"]
    monkeypatch.undo()
    monkeypatch.setitem(EVERYTHING, "scaled", (scaled, None))
    assert shapeless("scaled") == ["scaled: load has no shape"]
    assert repeats("drive_rate", "Its drive rate, (...).")
    assert not repeats("node", "Name of the node.")


def has(name: str, pattern: str | re.Pattern[str]) -> bool:
    """Whether a docstring, or that of the class it belongs to, has what a pattern finds."""
    return any(re.search(pattern, each.__doc__ or "") for each in EVERYTHING[name] if each is not None)


def test_equations_have_a_source_and_an_example() -> None:
    equations = [name for name, (thing, _) in EVERYTHING.items() if EQUATION.search(thing.__doc__)]
    assert len(equations) > 20
    assert not [name for name in equations if not has(name, ">>>")]
    assert not [name for name in equations if not has(name, SOURCE)]


def test_entry_points_have_an_example() -> None:
    package = importlib.import_module("linkframe")
    verbs = [getattr(getattr(package, cls), verb) for cls, names in ENTRY_POINTS.items() for verb in names.split()]
    assert not [verb.__qualname__ for verb in verbs if ">>>" not in verb.__doc__]
    functions = {name for name, (thing, cls) in EVERYTHING.items() if cls is None and inspect.isfunction(thing)}
    assert not {name for name in functions - {"movie", "picture"} if not has(name, ">>>")}


@pytest.mark.parametrize("name", modules())
def test_examples_in_docstrings_run(name: str) -> None:
    runner = doctest.DocTestRunner()
    found = doctest.DocTestFinder().find(importlib.import_module(name))
    # Each run looks at every file of which a line has been read: no run where there is no example.
    assert not [each.name for each in found if each.examples and runner.run(each).failed]
