"""How often 95 % intervals of probabilities hold: for 90 of 100 seeds at least, for every problem with a closed form.

python -m stress.intervals 100            # all problems, some ten minutes
python -m stress.intervals 100 RP22 RP57  # some
"""

from __future__ import annotations

import sys
import warnings
from typing import Any

from linkframe.framework.errors import SampleWarning
from linkframe.models import reliability
from reference.limit_states import PROBLEMS

METHODS: dict[str, dict[str, Any]] = {"importance": {"accuracy": 0.1}, "subset": {"samples": 500}}


def held(name: str, method: str, seeds: int) -> int:
    """In how many of so many runs the interval holds the exact probability."""
    problem, count = PROBLEMS[name], 0
    # Where subset simulation is led astray it warns, and its interval is as wide as that.
    warnings.simplefilter("ignore", SampleWarning)
    for seed in range(seeds):
        found = reliability(problem, problem.laws, method=method, rng=seed, **METHODS[method])
        low, high = found.confidence_interval(0.95)
        count += bool(low <= problem.probability <= high)
    return count


if __name__ == "__main__":
    many = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    wrong = []
    for each in sys.argv[2:] or PROBLEMS:
        counts = {method: held(each, method, many) for method in METHODS}
        print(f"{each:14}", *(f"{method} {count} of {many}" for method, count in counts.items()), sep="  ", flush=True)
        wrong += [f"{each} by {method}" for method, count in counts.items() if count < 0.9 * many]
    sys.exit(f"intervals hold too seldom: {', '.join(wrong)}" if wrong else 0)
