"""The long stress test: every axis against 50 digits, a million random models against double-double numbers, and
thousands of all kinds, by all methods, against the mixed method in 64 digits.

    python tests/stress/run.py --out stress-results
    python tests/stress/run.py --models 10000 --axes load units

It writes stress.csv, stress.md and stress.png, prints the table and the count, and fails where a number is further off
than its bound says, or a NaN is not announced.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from linkframe.framework import MechanismWarning

from stress.axes import AXES
from stress.chain import chain, tip
from stress.measure import Measured, measured, of_tip
from stress.mixed_kinds import METHODS
from stress.mixed_kinds import tally as mixed_tally
from stress.random_models import KINDS, Tally, tally
from stress.report import table, write

LINKS = (2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000)
# Models at a time, and those of one structure of all kinds.
CHUNK, MIXED = 1000, 10


def main() -> int:
    """Run what is asked for; the exit status tells whether a bound lied."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("stress-results"), help="folder for the results")
    names = [*(axis.name for axis in AXES), "chain"]
    parser.add_argument("--axes", nargs="+", choices=names, default=names, metavar="AXIS", help=", ".join(names))
    parser.add_argument("--models", type=int, default=1_000_000, help="random models")
    parser.add_argument("--mixed", type=int, default=2000, help="random structures of all kinds, ten models of each")
    parser.add_argument("--seed", type=int, default=0, help="of the random models")
    given = parser.parse_args()
    warnings.simplefilter("ignore", MechanismWarning)
    start = perf_counter()
    rows = list(along(given.axes))
    write(rows, given.out)
    print(table(rows))
    total = Tally()
    for index in range(-(-given.models // CHUNK)):
        rng = np.random.default_rng([given.seed, index])
        count = min(CHUNK, given.models - index * CHUNK)
        total += tally(rng, count, KINDS[index % len(KINDS)])
        if index % 50 == 49 or (index + 1) * CHUNK >= given.models:
            print(f"{total} in {perf_counter() - start:.0f} s", flush=True)
    mixed = Tally()
    for index in range(given.mixed):
        mixed += mixed_tally(np.random.default_rng([given.seed, 1, index]), MIXED, method=METHODS[index % len(METHODS)])
        if index % 100 == 99 or index + 1 == given.mixed:
            print(f"all kinds: {mixed} in {perf_counter() - start:.0f} s", flush=True)
    (given.out / "models.txt").write_text(f"{total}\nall kinds: {mixed}\n", encoding="utf-8")
    lies = sum(row.lies for row in rows) + sum(each.lies + each.silent for each in (total, mixed))
    return int(lies > 0)


def along(names: list[str]) -> Iterator[Measured]:
    """All places on the named axes."""
    for axis in AXES:
        if axis.name in names:
            for x in axis.long:
                yield from measured(axis.name, x, axis.build(x))
    if "chain" in names:
        for links in LINKS:
            structure = chain(links)
            yield of_tip("chain", links, structure, tip(structure))


if __name__ == "__main__":
    raise SystemExit(main())
