"""The command line: help, version, and what it says to bad input, which leaves nothing behind."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.framework.pictures import drawing_process
from linkframe.models.command_line import main, parser
from linkframe.models.paper import job
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.result import compute

# What is told of a stage that takes longer than a second, and nothing else.
PROGRESS = re.compile(
    r"[\w -]+: (\d+ s so far"
    r"|\d+ of \d+ samples at a pose, \d+ of \d+ at large displacement after \d+ s,"
    r" (about \d+ s to go|no estimate yet))"
)


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Error message of a command that must end with exit code 2."""
    code: object = None
    try:
        code = main(arguments)
    except SystemExit as end:  # argparse leaves this way
        code = end.code
    captured = capsys.readouterr()
    assert code == 2
    assert captured.out == ""
    assert "Traceback" not in captured.err
    return captured.err


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert re.fullmatch(r"linkframe \d+\.\d+\.\d+\n", capsys.readouterr().out)


def test_without_a_job_it_names_what_is_missing(capsys: pytest.CaptureFixture[str]) -> None:
    assert "JOB" in refused([], capsys)


def test_help_describes_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["four-bar", "--help"])
    assert end.value.code == 0
    text = capsys.readouterr().out
    headings = ["linkage:", "links:", "joints B, D and E:", "load at P:", "run:"]
    places = [text.index(f"\n{heading}") for heading in headings]
    assert places == sorted(places)
    assert "(default: None)" not in text


def test_defaults_are_the_example_of_the_paper() -> None:
    options = parser().parse_args(["four-bar"])
    assert (options.crank, options.coupler, options.rocker, options.ground) == (0.1, 0.2, 0.1, 0.2)
    assert (options.point, options.section, options.young) == ((0.1, 0.0), (6.35e-3, 12.7e-3), 2e11)
    assert (options.stiffness, options.stiffness_sd, options.load, options.load_sd) == (2e11, 1e10, 100.0, 5.0)
    assert (options.clearance, options.clearance_sd, options.contact, options.contact_sd) == (1e-3, 5e-5, 180.0, 180.0)
    assert (options.poses, options.samples, options.rng) == ((0.0, 360.0, 10.0), 100, 0)


@pytest.mark.parametrize("option", ["--crank", "--coupler", "--rocker", "--ground", "--young"])
@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf", "long"])
def test_sizes_must_be_positive(option: str, value: str, capsys: pytest.CaptureFixture[str]) -> None:
    message = refused(["four-bar", option, value], capsys)
    assert f"argument {option}: is '{value}': give a finite number greater than 0" in message


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--poisson", "0.5"], ["--poisson", "'0.5'", "between -1 and 0.5"]),
        (["--section", "0.01", "-0.01"], ["--section", "'-0.01'", "greater than 0"]),
        (["--stiffness", "-1"], ["--stiffness", "'-1'", "greater than 0, or inf"]),
        (["--stiffness", "inf"], ["--stiffness inf", "--stiffness-sd 0"]),
        (["--clearance", "-1e-3"], ["--clearance", "'-1e-3'", "0 or greater"]),
        (["--clearance-sd", "1e-3"], ["--clearance-sd", "0.001", "at most 0.0002"]),
        (["--length-sd", "0.03"], ["--length-sd", "--crank 0.1", "at most 0.02"]),
        (["--contact", "reaction", "--load", "0"], ["contact", "reaction", "load"]),
        (["--contact", "equilibrium", "--load", "0"], ["contact", "equilibrium", "load"]),
        (["--poses", "0", "0", "1"], ["no pose is left", "singular"]),
        (["--clearance-sd", "inf"], ["--clearance-sd", "'inf'", "finite"]),
        (["--contact", "north"], ["--contact", "'north'", "reaction or equilibrium"]),
        (["--load", "nan"], ["--load", "'nan'", "finite"]),
        (["--samples", "1"], ["--samples", "'1'", "2 or greater"]),
        (["--samples", "2.5"], ["--samples", "'2.5'", "whole number"]),
        (["--rng", "-1"], ["--rng", "'-1'", "0 or greater"]),
        (["--branch", "left"], ["--branch", "'left'", "parallel"]),
        (["--in-plane", "0.01"], ["--in-plane", "'0.01'", "long"]),
        (["--poses", "0", "360", "0"], ["--poses", "0 360 0", "STEP > 0"]),
        (["--poses", "90", "0", "10"], ["--poses", "90 0 10", "LAST ≥ FIRST"]),
        (["--poses", "0", "360", "1e-9"], ["--poses", "greater STEP"]),
        (["--histogram-pose", "33"], ["--histogram-pose 33", "none of the poses", "30"]),
        (
            ["--histogram-pose", "180", "--samples", "3"],
            ["--histogram-pose 180", "singular (direct-kinematic, type II): coupler and rocker in line"],
        ),
        (["--ground", "0.5"], ["no pose can be assembled", "--ground 0.5", "gap of 0.1 m", "at 0°"]),
        (["--frobnicate"], ["--frobnicate"]),
    ],
    ids=lambda value: " ".join(value[:2]) if value[0].startswith("--") else "",
)
def test_bad_input_is_named_and_leaves_nothing(
    arguments: list[str], parts: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "deep" / "results"
    message = refused(["four-bar", *arguments, "--out", str(out)], capsys)
    for part in parts:
        assert part in message
    assert list(tmp_path.iterdir()) == []


def test_directory_that_cannot_be_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    message = refused(["four-bar", "--out", str(tmp_path / "file" / "results")], capsys)
    assert str(tmp_path / "file" / "results") in message
    assert "choose a folder that can be written" in message
    assert (tmp_path / "file").read_text(encoding="utf-8") == "in the way"


def test_directory_that_is_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    assert str(tmp_path / "file") in refused(["four-bar", "--out", str(tmp_path / "file")], capsys)


def test_directory_without_permission_to_write(capsys: pytest.CaptureFixture[str]) -> None:
    # /proc refuses to make files for every user, root included.
    for out in ("/proc", "/proc/linkframe", "/proc/link/frame"):
        message = refused(["four-bar", "--out", out], capsys)
        assert f"{out} " in message or f"{out}:" in message


def test_interrupted_job_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(job, "report", interrupted)
    options = ["--poses", "30", "60", "10", "--samples", "5", "--figures", "none"]
    assert main(["four-bar", *options, "--out", str(tmp_path / "a" / "b")]) == 130
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("encoding", "figures"), [("ascii", "all"), ("cp1252", "none")])
def test_terminals_without_greek_letters(
    tmp_path: Path, encoding: str, figures: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The table, what is told where nothing can be rendered, and the help."""
    options = ["four-bar", "--poses", "30", "30", "1", "--samples", "2", "--figures", figures]
    options += ["--out", str(tmp_path / "out")]
    monkeypatch.setattr(drawing_process, "PROGRAM", "raise SystemExit(1)")
    for arguments, told in ((options, "table1.csv"), (["four-bar", "--help"], "clearance e")):
        printed = {name: TextIOWrapper(BytesIO(), encoding=encoding) for name in ("stdout", "stderr")}
        with monkeypatch.context() as terminal, suppress(SystemExit):  # argparse leaves the help this way
            for name, stream in printed.items():
                terminal.setattr(sys, name, stream)
            assert main(arguments) == 0
        out, err = (stream.buffer.getvalue().decode(encoding) for stream in flushed(printed))
        assert told in out
        assert all(PROGRESS.fullmatch(line) for line in err.splitlines())
    assert (tmp_path / "out" / "report.md").is_file()


def flushed(printed: dict[str, TextIOWrapper]) -> Iterator[Any]:
    for stream in printed.values():
        stream.flush()
        yield stream


def test_a_process_without_greek_letters() -> None:
    outcome = subprocess.run(
        [sys.executable, "-c", "from linkframe.models.command_line import main; main(['four-bar', '--help'])"],
        capture_output=True,
        env=os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"},
        check=False,
    )
    assert (outcome.returncode, outcome.stderr) == (0, b"")
    assert "clearance e" in outcome.stdout.decode("ascii")


def test_installed_command_prints_no_traceback(tmp_path: Path) -> None:
    command = [
        str(Path(sys.executable).with_name("linkframe")),
        "four-bar",
        "--ground",
        "0.5",
        "--out",
        str(tmp_path / "x"),
    ]
    outcome = subprocess.run(command, capture_output=True, text=True, check=False)
    assert outcome.returncode == 2
    assert outcome.stderr.splitlines()[-1].startswith("linkframe four-bar: error: ")
    assert "Traceback" not in outcome.stderr


def test_contact_in_equilibrium_is_along_the_joint_forces() -> None:
    """Without springs about the pins the forces follow from equilibrium, whether the joints have clearance or not."""
    given = parser().parse_args(["four-bar", "--contact", "equilibrium"]).contact
    inputs = Inputs(contact=given, poses=(30.0, 90.0, 30.0), samples=10)
    by_file, by_forces = (compute(each, large=False).mean for each in (inputs, inputs.but(contact="reaction")))
    np.testing.assert_allclose(by_file, by_forces, rtol=1e-9)


@pytest.mark.parametrize("words", [["--version"], ["--help"], ["run", "--help"]])
def test_nobody_reads_what_is_printed(words: list[str]) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    outcome = subprocess.run(
        [sys.executable, "-m", "linkframe", *words], stdout=writer, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writer)
    assert not outcome.stderr
    assert outcome.returncode in (0, 141)  # argparse prints help to nobody without a word


@pytest.mark.skipif(os.name != "posix", reason="a shell closes the streams")
@pytest.mark.parametrize("closed", [">&-", ">&- 2>&-"])
def test_streams_that_were_closed_before(closed: str, tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "examples/four_bar.toml").read_text(encoding="utf-8")
    (tmp_path / "short.toml").write_text(text.replace("steps = 37", "steps = 2"), encoding="utf-8")
    command = f'"{sys.executable}" -m linkframe run short.toml --figures none --out out {closed}'
    assert subprocess.run(command, shell=True, check=False, cwd=tmp_path).returncode == 0
    assert (tmp_path / "out/table.csv").read_text(encoding="utf-8").count("\n") >= 2


def test_a_wrong_tolerance_is_shown_how_to_write_one(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["run", "linkage.toml", "--tolerance", "nonsense"])
    assert "give NAME=VALUE, such as 'joints.B.clearance=± 5 %'\n" in capsys.readouterr().err
