"""What is computed once does not make others wait, and is one object for all who ask; so is a module loaded later."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from threading import Barrier
from types import ModuleType

import pytest
from linkframe.framework.lazily import cached_property


def test_objects_of_a_class_compute_at_the_same_time() -> None:
    """Each waits inside for the other."""
    both = Barrier(2)

    class Counted:
        times = 0

        @cached_property
        def value(self) -> int:
            both.wait(timeout=5.0)
            self.times += 1
            return self.times

    one, other = Counted(), Counted()
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(lambda each: each.value, (one, other))) == [1, 1]
    assert one.value == other.value == 1
    assert one.times == other.times == 1


def test_one_object_for_two_threads() -> None:
    """Both compute it; what each is given, and what is kept, is that of one of them."""
    both = Barrier(2)

    class Owner:
        @cached_property
        def value(self) -> object:
            both.wait(timeout=5.0)
            return object()

    owner = Owner()
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(lambda _: owner.value, range(2))
    assert first is second is owner.value


def test_found_by_name_and_left_alone_where_it_is_set() -> None:
    """It is an attribute of the object like any other: a subclass may override it, a copy may set it, or drop it."""

    class Owner:
        @cached_property
        def value(self) -> int:
            """What it is."""
            return 1

    class Other(Owner):
        @cached_property
        def value(self) -> int:
            return 1 + Owner.value.__get__(object.__new__(Owner))

    assert Owner.value.__doc__ == "What it is."
    assert Other().value == 2
    given = Owner()
    vars(given)["value"] = 3
    assert given.value == 3
    del given.value
    assert given.value == 1


PACKAGE = """
from linkframe.framework.lazily import loaded_later
__getattr__, __dir__ = loaded_later(__name__, {"answer": ".slow"}, modules=["slow", "never"])
"""
# Takes its time, so that other threads find it half loaded.
SLOW = """
import time
from . import early
early.loads.append(__name__)
time.sleep(0.2)
answer = 42
def told():
    return answer
"""
USER = """
from . import early, slow
def asked():
    return slow.told()
"""


@pytest.fixture
def parcel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """A package whose file `user` names at its top what is loaded later."""
    (tmp_path / "parcel").mkdir()
    for name, text in {"__init__": PACKAGE, "slow": SLOW, "early": "loads = []", "user": USER}.items():
        (tmp_path / "parcel" / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    yield import_module("parcel")
    for name in [name for name in sys.modules if name.partition(".")[0] == "parcel"]:
        del sys.modules[name]


@pytest.mark.usefixtures("parcel")
def test_module_that_is_named_at_the_top_is_loaded_when_first_used() -> None:
    user = import_module("parcel.user")
    assert "parcel.slow" not in sys.modules
    assert "parcel.early" in sys.modules
    assert [user.asked(), user.asked()] == [42, 42]
    assert user.early.loads == ["parcel.slow"]
    assert user.slow.told is sys.modules["parcel.slow"].told
    with pytest.raises(AttributeError, match=r"'parcel\.slow' has no attribute 'untold'"):
        _ = user.slow.untold


@pytest.mark.usefixtures("parcel")
def test_threads_wait_until_a_module_is_loaded() -> None:
    user, together = import_module("parcel.user"), Barrier(4)

    def asked(_: int) -> object:
        together.wait(timeout=5.0)
        return user.asked()

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(asked, range(4))) == [42] * 4
    assert user.early.loads == ["parcel.slow"]


@pytest.mark.usefixtures("parcel")
@pytest.mark.parametrize("loaded", [False, True])
def test_what_is_set_in_a_module_is_seen_by_those_who_load_it_later(
    monkeypatch: pytest.MonkeyPatch, loaded: bool
) -> None:
    """As tests do it: in the module itself, in what stands for it, or by its name."""
    user = import_module("parcel.user")
    if loaded:
        user.asked()
    with monkeypatch.context() as patch:
        patch.setattr(user.slow, "answer", 1)
        patch.setattr(user.slow, "more", 2, raising=False)
        assert user.asked() == 1
        assert sys.modules["parcel.slow"].more == 2
    assert user.asked() == 42
    assert not hasattr(sys.modules["parcel.slow"], "more")
    with monkeypatch.context() as patch:
        patch.setattr("parcel.slow.answer", 3)
        assert user.asked() == 3
    with monkeypatch.context() as patch:
        patch.setattr(sys.modules["parcel.slow"], "told", lambda: 4)
        assert user.asked() == 4
    assert user.asked() == 42


def test_package_has_what_it_names_and_no_more(parcel: ModuleType) -> None:
    assert "parcel.slow" not in sys.modules
    assert "answer" in dir(parcel)
    assert parcel.answer == 42
    with pytest.raises(AttributeError, match="'parcel' has no attribute 'question'"):
        _ = parcel.question
    with pytest.raises(ModuleNotFoundError, match=r"parcel\.never"):
        _ = parcel.never.answer
