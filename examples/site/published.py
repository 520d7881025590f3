"""The published cases, solved again: the tests that hold them are run, and each comparison that they make is noted."""

import json
import os
import subprocess
import sys
from pathlib import Path

HEAD = """.. list-table::
   :header-rows: 1
   :widths: 46 18 18 18

   * - case
     - published or exact
     - linkframe
     - apart by""".splitlines()

RELIABILITY = "tests/models/test_reliability.py"
TESTS = (
    "tests/validation",
    "tests/linkage/test_reference_andrews.py",
    "tests/linkage/test_reference_iftomm.py",
    "tests/linkage/test_reference_textbooks.py",
    "tests/large/test_bend.py",
    "tests/large/test_limits.py",
    "tests/large/test_stability.py",
    f"{RELIABILITY}::test_planes_have_their_probability",
    f"{RELIABILITY}::test_correlated_inputs_with_nataf",
    f"{RELIABILITY}::test_a_frame_of_uncertain_stiffness_place_and_load",
)


def prepare(top: Path, target: Path) -> None:
    """Run the tests and write a table for each file of them to `target`."""
    target.parent.mkdir(parents=True, exist_ok=True)
    noted = target.with_suffix(".json")
    here = str(Path(__file__).parent)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([here, os.environ.get("PYTHONPATH", "")])}
    environment["NOTED_COMPARISONS"] = str(noted)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "noted_comparisons", *TESTS]
    done = subprocess.run(command, cwd=top, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"a published case is not met:\n{done.stdout[-4000:]}{done.stderr[-2000:]}")
    target.write_text("\n".join(_lines(json.loads(noted.read_text(encoding="utf-8")))), encoding="utf-8")


def _lines(files: dict) -> list[str]:
    lines = []
    for told in files.values():
        title = _plain(told["title"])
        lines += ["", title, "-" * len(title), "", *HEAD]
        for case, *figures in told["rows"]:
            lines += [f"   * - {_plain(case)}", *(f"     - {figure}" for figure in figures)]
    return [*lines, ""]


def _plain(text: str) -> str:
    """Text in which nothing is mark-up."""
    text = " ".join(text.split())
    return "".join(f"\\{letter}" if letter in "*`|_\\" else letter for letter in text)
