"""Files that were damaged at random: what is wrong is told as a FrameError with its line, and by nothing else."""

from __future__ import annotations

import random
import re
import warnings
from pathlib import Path

import pytest
from linkframe.framework import FrameError
from linkframe.models.linkage import read_linkage
from linkframe.models.linkage.job.inputs import read_inputs

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))
DEEP = """\
[points]
A = [0.0, 0.0]
B = [1.0, 0.0]

[links.arm]
points = ["A", "B"]
mass = 2.0

[joints.A]
kind = "universal"
point = "A"
links = ["ground", "arm"]
axis = [0.0, 0.0, 1.0]
second = [1.0, 0.0, 0.0]
drive = ["rz"]
stiffness = [inf, inf, inf, 0.0, inf, 0.0]

[[springs]]
between = ["B", ["ground", "A"]]
stiffness = 2e3
length = 0.1

[[loads]]
link = "arm"
point = "B"
fy = 1.0
follower = true

[run.drives.A]
values = [0.0, 10.0]
unit = "deg"
rate = [1.0, 2.0]

[tolerances.stiff]
of = ["springs.0.stiffness", "points.B.x"]
distribution = "norm"
scale = "5 %"
"""
VALUES = (
    *("[", "]", "{", "1e400", "-1e400", "1e-400", "9" * 400, "9" * 5000, "0x" + "f" * 400, "inf", "nan", "-inf", "-1"),
    *("0", "2.5", "true", '"x"', '""', "[]", "{}", "[1, 2]", "[[1.0], [2.0, 3.0]]", '["A", "B"]', "[1, 2, 3]"),
    *("[[1,0,0],[0,1,0],[0,0,1]]", "1979-05-27", "07:32:00", "[[[[1]]]]", "{a = 1}", "[{a = 1}]", "[" * 3000),
    *("[" * 40 + "]" * 40, '"ground"', '"norm"', "[true]", '"5 %"', "[inf]", "'''\nx\n'''", "[nan, 1]"),
)


def damaged(text: str, rng: random.Random) -> str:
    """The text with one to three values, lines or signs replaced, left out, doubled or moved."""
    lines = text.split("\n")
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        k, j = rng.randrange(len(lines)), rng.randrange(len(lines))
        line, how = lines[k], rng.randrange(8)
        numbers = list(re.finditer(r"-?\d[\d.e+-]*|\"[^\"]*\"", line))
        if how < 3 and "=" in line:
            lines[k] = f"{line.split('=')[0]}= {rng.choice(VALUES)}"
        elif how < 5 and numbers:
            number = rng.choice(numbers)
            lines[k] = line[: number.start()] + rng.choice(VALUES) + line[number.end() :]
        elif how == 5 and line:
            i = rng.randrange(len(line))
            lines[k] = line[:i] + rng.choice("[]{}=\"'#.,\\\t-+019eE x\x00é") + line[i + rng.randrange(2) :]
        elif how == 6:
            lines[k : k + 1] = [line] * rng.choice((0, 2))
            lines = lines or [""]
        else:
            lines[k], lines[j] = lines[j], line
    return "\n".join(lines)


@pytest.mark.parametrize("seed", range(10))
def test_a_damaged_file_is_refused_by_line_or_read(seed: int, tmp_path: Path) -> None:
    texts, rng, path = [DEEP, *(example.read_text() for example in EXAMPLES)], random.Random(seed), tmp_path / "f.toml"
    for _ in range(30):
        path.write_text(damaged(rng.choice(texts), rng), encoding="utf-8")
        told = refusal(path)
        assert told is None or re.match(rf"{re.escape(str(path))}, line \d+", told), told
        assert len(told or "") < 1000


def refusal(path: Path) -> str | None:
    """What the reader says against a file; None where it takes it."""
    try:
        read_inputs(path)
    except FrameError as error:
        return str(error)
    return None


@pytest.mark.parametrize(
    ("old", "new", "line", "told"),
    [
        ("mass = 2.0", "mass = " + "[" * 5000 + "]" * 5000, 7, "more than 32 deep"),
        ("mass = 2.0", "mass = " + "[" * 40 + "]" * 40, 7, "more than 32 deep"),
        ("mass = 2.0", "mass = " + "9" * 20000, 7, "has more than 4300 digits"),
        ("mass = 2.0", "mass = 1" + "0" * 400, 7, "links.arm.mass: has a number beyond the range of floats"),
        ("mass = 2.0", "mass = 0x" + "f" * 5000, 7, "links.arm.mass: has a number beyond the range of floats"),
        ("mass = 2.0", "mass = 1e400", 7, "1e400 is beyond the range of floats"),
        ("mass = 2.0", "mass = 1e-400", 7, "1e-400 is beyond the range of floats"),
        ("mass = 2.0", "mass = [2.0, [1.0]]", 7, "give a number, or a list of numbers"),
        ("values = [0.0, 10.0]", "values = [[0.0, 10.0]]", 30, "give finite numbers, one a pose"),
        ("values = [0.0, 10.0]", "values = []", 30, "give finite numbers, one a pose"),
        ("values = [0.0, 10.0]", "values = [0.0, inf]", 30, "give finite numbers, one a pose"),
        ("rate = [1.0, 2.0]", "start = 0.0", 32, "has no effect beside values"),
        ('scale = "5 %"', "scale = [1.0, 2.0]", 37, "tolerances.stiff.scale: is [1.0, 2.0]: give one number"),
        ('distribution = "norm"', "[", 36, "this is not TOML"),
        ('scale = "5 %"', "samples = [", 37, "this is not TOML"),
        ("follower = true", "[run]\nsamples = 2\npose = " + "9" * 400, 29, "run.pose: is 999"),
        ("follower = true", "[run]\nsamples = 2\npoint = 3", 29, "there is no such key here"),
    ],
)
def test_what_no_float_can_hold_is_told_by_its_line(old: str, new: str, line: int, told: str, tmp_path: Path) -> None:
    assert DEEP.count(old) == 1
    path = tmp_path / "f.toml"
    path.write_text(DEEP.replace(old, new), encoding="utf-8")
    with pytest.raises(FrameError) as refused:
        read_inputs(path)
    assert str(refused.value).startswith(f"{path}, line {line}")
    assert told in str(refused.value)
    assert len(str(refused.value)) < 1000


def test_lines_are_counted_as_an_editor_counts_them(tmp_path: Path) -> None:
    """Behind strings of several lines, which look like tables, and line separators that are none in an editor."""
    path = tmp_path / "f.toml"
    path.write_text('title = """\n[points]\nA = 3\n"""\n' + DEEP.replace('"x"', "") + "\n[tables]\n", encoding="utf-8")
    with pytest.raises(FrameError, match=rf"line {DEEP.count(chr(10)) + 6}, tables: there is no such table"):
        read_linkage(path)
    path.write_text('title = "a\u2028b"\n[points]\nA = "here"\n', encoding="utf-8")
    with pytest.raises(FrameError, match=r"line 3, points\.A"):
        read_linkage(path)


def test_numbers_as_they_are_written_by_the_program_are_read(tmp_path: Path) -> None:
    path = tmp_path / "f.toml"
    least = "5e-324"
    path.write_text(
        DEEP.replace("mass = 2.0", f"mass = {least}").replace("2e3", "1.7976931348623157e308"), encoding="utf-8"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        linkage = read_linkage(path)
    assert linkage.links["arm"].mass == 5e-324
    assert linkage.springs[0].stiffness == 1.7976931348623157e308
