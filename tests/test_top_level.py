"""``import linkframe``: every public name of the three packages, loaded when it is first used."""

from __future__ import annotations

import pydoc
import runpy
import subprocess
import sys
from importlib import import_module
from importlib.metadata import version

import linkframe
import pytest

PACKAGES = [import_module(f"linkframe.{name}") for name in ("framework", "elements", "models")]


def run(*words: str) -> str:
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, check=True).stdout


def test_every_public_name_is_there() -> None:
    from linkframe import Beam, FourBar, Frame, Linkage

    assert all(isinstance(each, type) for each in (Beam, FourBar, Frame, Linkage))
    for package in PACKAGES:
        for name in package.__all__:
            assert getattr(linkframe, name) is getattr(package, name)
            assert name in dir(linkframe)


def test_star() -> None:
    names: dict[str, object] = {}
    exec("from linkframe import *", names)
    assert {name for package in PACKAGES for name in package.__all__} <= set(names)


def test_no_name_has_two_meanings() -> None:
    names = [name for package in PACKAGES for name in package.__all__]
    assert len(names) == len(set(names))


def test_unknown_name() -> None:
    with pytest.raises(AttributeError, match="module 'linkframe' has no attribute 'Frames'"):
        linkframe.Frames  # noqa: B018


def test_version() -> None:
    assert linkframe.__version__ == version("linkframe")


def test_help_tells_of_the_three_packages() -> None:
    text = pydoc.plain(pydoc.render_doc(linkframe))
    assert all(f"linkframe.{name}" in text for name in ("framework", "elements", "models"))
    assert "from linkframe import Beam, Frame" in text


def test_import_loads_nothing_but_itself() -> None:
    loaded = run("-c", "import sys, linkframe; print(*sys.modules)").split()
    assert not [name for name in loaded if name.startswith("linkframe.")]
    assert "numpy" not in loaded


def test_a_frame_needs_no_linkage() -> None:
    loaded = run("-c", "import sys; from linkframe import Frame; print(*sys.modules)").split()
    assert "linkframe.framework.frame" in loaded
    assert not {"linkframe.elements", "linkframe.models", "skfem"}.intersection(loaded)


def test_command() -> None:
    assert run("-m", "linkframe", "--version") == f"linkframe {version('linkframe')}\n"


def test_interrupt_while_the_command_is_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    from linkframe import __main__, models

    class Interrupted:
        def __getattr__(self, name: str) -> object:
            raise KeyboardInterrupt

    # as in a process that has not loaded it yet
    monkeypatch.delitem(vars(models), "command_line", raising=False)
    monkeypatch.setitem(sys.modules, "linkframe.models.command_line", Interrupted())
    assert runpy.run_path(__main__.__file__)["main"]() == 130
