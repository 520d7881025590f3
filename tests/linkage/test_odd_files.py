"""Files as other programs and hasty hands write them: read where the meaning is plain, refused by line where not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models.linkage import read_linkage
from linkframe.models.linkage.job.inputs import read_inputs

ARM = """\
[points]
A = [0.0, 0.0]
B = [1.0, 0.0]

[links.arm]
points = ["A", "B"]
beam = "bar"

[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "arm"]
drive = true

[[loads]]
point = "B"
fy = 1.0

[beams.bar]
section = "flat"
material = "steel"
segments = 1

[sections.flat]
shape = "rectangle"
y = 0.02
z = 0.01

[materials.steel]
E = 2e11
nu = 0.3

[run]
points = ["B"]
pose = 10.0

[run.drives.A]
start = 0.0
stop = 10.0
steps = 2
unit = "deg"
"""


@pytest.mark.parametrize("written", [b"\xef\xbb\xbf" + ARM.encode(), ARM.replace("\n", "\r\n").encode()])
def test_files_of_windows_editors_are_read(written: bytes, tmp_path: Path) -> None:
    plain, marked = tmp_path / "plain.toml", tmp_path / "Kurbel ä" / "marked.toml"
    marked.parent.mkdir()
    plain.write_text(ARM, encoding="utf-8")
    marked.write_bytes(written)
    for name, point in read_linkage(plain).points.items():
        np.testing.assert_array_equal(read_linkage(marked).points[name], point)
    assert read_inputs(marked).points == ("B",)


FLAT = "[sections.flat]"


@pytest.mark.parametrize(
    ("old", "new", "line", "told"),
    [
        ('shape = "rectangle"\n', "", FLAT, "sections.flat: has no shape: give its name in quotes, one of rectangle"),
        ("y = 0.02\n", "", FLAT, "sections.flat: has no y: give shape, y, z"),
        ("y = 0.02\n", "y = 0.02\nw = 0.02\n", "w = 0.02", "sections.flat.w: there is no such key here: use one of"),
        (f"{FLAT}\nshape = ", "[sections]\nflat = ", "flat = ", "sections.flat: is 'rectangle': give a table, " + FLAT),
        ("drive = true", 'drive = "yes"', "drive = ", "joints.A.drive: is 'yes': give true, or a list of coordinates"),
        ("segments = 1", 'segments = "1"', "segments", "beams.bar.segments: is '1': give a whole number"),
        ('points = ["B"]\n', 'points = ["B", "B"]\n', 'points = ["B", "B"]', "run.points.1: names 'B' a second time"),
        ("steps = 2", "steps = 1", "steps", "run.drives.A.steps: is 1, a single pose from 0 to 10"),
    ],
)
def test_what_is_odd_is_told_by_its_line(old: str, new: str, line: str, told: str, tmp_path: Path) -> None:
    assert old in ARM
    text = ARM.replace(old, new)
    file = tmp_path / "arm.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(FrameError) as caught:
        read_inputs(file)
    number = next(k for k, each in enumerate(text.splitlines(), start=1) if each.startswith(line))
    assert f"line {number}, {told}" in str(caught.value)


def test_drives_that_are_no_table_name_the_table_wanted(tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(ARM.split("[run.drives.A]")[0] + "drives = 3\n", encoding="utf-8")
    with pytest.raises(FrameError, match=r"run.drives: is 3: give a table of tables, such as \[run.drives.name\]"):
        read_inputs(file)
