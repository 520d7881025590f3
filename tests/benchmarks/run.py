"""All benchmarks, or those named, each in a process of its own: CSV, PNG, and a summary of targets and measurements.

    python tests/benchmarks/run.py --out benchmarks-results            # all
    python tests/benchmarks/run.py --quick paper_job segments          # small sizes of two

Peers come with ``pip install '.[bench]'``; those that are not installed, or fail as they are
loaded, are left out, which is told.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter

BENCHMARKS = (
    "paper_job",
    "all_results",
    "everything_random",
    "samples",
    "segments",
    "size",
    "large_frames",
    "work_precision",
    "start_up",
    "kinematics",
    "large_displacement",
    "programs",
    "middle",
    "one_frame",
    "reliability",
    "bulk",
    "clearances",
)
PACKAGES = (
    "linkframe",
    "numpy",
    "scipy",
    "scikit-fem",
    "openseespy",
    "PyNiteFEA",
    "calfem-python",
    "cvxopt",
    "llvmlite",
    "numba",
    "pypardiso",
    "pylinkage",
    "exudyn",
    "openturns",
)


def main() -> int:
    """Run, and summarise; the exit status is that of the benchmarks, not of the targets."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one of {', '.join(BENCHMARKS)}; all where none")
    parser.add_argument("--out", type=Path, default=Path("benchmarks-results"), help="folder for the results")
    parser.add_argument("--quick", action="store_true", help="small sizes: two minutes instead of a quarter of an hour")
    given = parser.parse_args()
    unknown = sorted(set(given.names) - set(BENCHMARKS))
    if unknown:
        parser.error(f"no benchmark is named {', '.join(unknown)}: choose from {', '.join(BENCHMARKS)}")
    given.out.mkdir(parents=True, exist_ok=True)
    failed = [name for name in given.names or BENCHMARKS if not run(name, given.out, given.quick)]
    text = summary(given.out, given.quick)
    (given.out / "summary.md").write_text(text, encoding="utf-8")
    print(f"\n{text}")
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return len(failed)


def run(name: str, out: Path, quick: bool) -> bool:
    """Run one benchmark; whether it came to its end."""
    (out / f"{name}.targets.json").unlink(missing_ok=True)
    # One thread each: linear algebra of others on several cores would be compared with one core.
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **threads, "PYTHONPATH": str(Path(__file__).parents[1])}
    # What pip installs is compiled; a source tree is so only if Python may write.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-m", f"benchmarks.{name}", "--out", str(out), *(["--quick"] if quick else [])]
    print(f"\n== {name}", flush=True)
    start, before = perf_counter(), os.times()
    done = subprocess.run(command, env=environment).returncode == 0
    spent, after = perf_counter() - start, os.times()
    # On a machine that is shared much more time passes than the benchmark takes.
    busy = after.children_user - before.children_user + after.children_system - before.children_system
    print(f"\n{name}: {spent:.0f} s, {busy:.0f} s of processor time", flush=True)
    return done


def summary(out: Path, quick: bool) -> str:
    """Targets of all benchmarks whose results lie in `out`, as a table in Markdown."""
    files = [out / f"{name}.targets.json" for name in BENCHMARKS]
    targets = [target for file in files if file.exists() for target in json.loads(file.read_text(encoding="utf-8"))]
    lines = [
        "# Benchmarks",
        "",
        f"{processor()}, one core; Python {platform.python_version()}; {', '.join(versions())}."
        + (" Small sizes (--quick): not the numbers to go by." if quick else ""),
        "",
        "| benchmark | target | measured | met |",
        "| :-- | :-- | :-- | :-: |",
    ]
    lines += [
        f"| {t['benchmark']} | {t['target']} | {t['measured']} | {'yes' if t['met'] else 'no'} |" for t in targets
    ]
    bounds = [f"* {t['benchmark']}, {t['target']}: {t['bound']}." for t in targets if not t["met"] and t["bound"]]
    if bounds:
        lines += ["", "What bounds those that were not met:", "", *bounds]
    return "\n".join(lines) + "\n"


def processor() -> str:
    """Name of the processor."""
    info = Path("/proc/cpuinfo")
    names = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    return next((line.split(":")[1].strip() for line in names if line.startswith("model name")), platform.machine())


def versions() -> list[str]:
    """Versions of what is compared."""
    found = []
    for package in PACKAGES:
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            found.append(f"{package} not installed")
    return found


if __name__ == "__main__":
    sys.exit(main())
