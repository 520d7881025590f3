"""Machine code on disk: taken up by the next process, never when it is damaged, another's, or switched off."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework.cache import KERNELS
from linkframe.framework.program import kept_code, machine_code
from linkframe.framework.program.calculation import Calculation
from linkframe.framework.program.recording import Recording

pytestmark = pytest.mark.skipif(not machine_code.available(), reason="llvmlite is not installed")


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names under which code was kept, one for each time that something was compiled."""
    names: list[str] = []
    write = kept_code.write
    monkeypatch.setattr(kept_code, "write", lambda name, content: names.append(name) or write(name, content))
    return names


def anew() -> np.ndarray:
    """The sine of some numbers, by a process that has compiled nothing yet."""
    KERNELS.clear()
    recording = Recording(fixed=True)
    program, _ = recording.program([np.sin(recording.later(1))])
    (found,) = Calculation(program, [np.linspace(0.0, 5.0, 40)], (40,), compiled=True).results()
    return np.asarray(found)


def test_compiled_once_for_all_processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiled: list[str]) -> None:
    monkeypatch.setenv("LINKFRAME_CACHE", str(tmp_path / "new" / "folder"))
    first, again = anew(), anew()
    np.testing.assert_array_equal(first, again)
    np.testing.assert_allclose(first, np.sin(np.linspace(0.0, 5.0, 40)), rtol=2e-16)
    assert len(compiled) == 1
    assert [path.suffix for path in (tmp_path / "new" / "folder").iterdir()] == [".o"]


def test_another_processor_or_version_has_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiled: list[str]
) -> None:
    monkeypatch.setenv("LINKFRAME_CACHE", str(tmp_path))
    anew()
    monkeypatch.setattr(machine_code, "llvmlite_version", lambda: "another")
    anew()
    assert len(set(compiled)) == 2


@pytest.mark.parametrize("place", [0, 30, 60, 400])
def test_damaged_files_are_compiled_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiled: list[str], place: int
) -> None:
    monkeypatch.setenv("LINKFRAME_CACHE", str(tmp_path))
    first = anew()
    (path,) = tmp_path.iterdir()
    whole = bytearray(path.read_bytes())
    whole[place] ^= 1
    path.write_bytes(whole if place < 400 else whole[:place])
    np.testing.assert_array_equal(anew(), first)
    anew()
    assert len(compiled) == 2


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no rights of files there")
def test_what_others_may_write_to_is_not_taken_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiled: list[str]
) -> None:
    monkeypatch.setenv("LINKFRAME_CACHE", str(tmp_path))
    anew()
    tmp_path.chmod(0o777)
    anew()
    assert len(compiled) == 2


def test_switched_off_and_without_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiled: list[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("LINKFRAME_CACHE", "off")
    assert kept_code.folder() is None
    anew()
    assert not list(tmp_path.iterdir())
    monkeypatch.delenv("LINKFRAME_CACHE")
    assert kept_code.folder() == tmp_path / "linkframe"
    (tmp_path / "file").touch()
    monkeypatch.setenv("LINKFRAME_CACHE", str(tmp_path / "file" / "below"))
    anew()
    anew()
    assert len(compiled) == 3


def test_the_oldest_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LINKFRAME_CACHE", str(tmp_path))
    monkeypatch.setattr(kept_code, "MOST", 3)
    for k in range(5):
        kept_code.write(str(k), b"code")
        os.utime(tmp_path / f"{k}.o", (k, k))
        if k == 2:
            assert kept_code.read("0") == b"code"
    assert sorted(path.stem for path in tmp_path.iterdir()) == ["0", "3", "4"]
