"""Flights of random missions, each judged by its messages and proved by its log.

    python bench/random_missions.py --count 1000

Each seed draws one mission (tests/flight/random_missions.py): rules on board, faults of the link, ways home, holds
and schedules, under each autonomy. A flight passes if tests/flight/flight_oracle.py finds nothing against it and
`replay` says EXACT. What fails is printed with its seed; the exit code is 1 if anything does.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.flight.random_missions import judged  # noqa: E402 - the repository's root is no installed package
from waypointctl.policy.bundle import load_policy  # noqa: E402


def main() -> int:
    """Fly, print what is wrong and a summary; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000, help="how many seeds")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    asked = parser.parse_args()
    policy = load_policy(ROOT / "policies" / "ant-waypoint")
    outcomes: Counter[str] = Counter()
    wrong = went_home = 0
    began_s = time.monotonic()
    with TemporaryDirectory() as folder:
        for seed in range(asked.first, asked.first + asked.count):
            flight = judged(seed, policy, Path(folder))
            outcomes[flight.result.outcome] += 1
            went_home += flight.went_home
            wrong += bool(flight.faults)
            if seed % 100 == 99:
                print(f"{seed - asked.first + 1} flown in {time.monotonic() - began_s:.0f} s", flush=True)
            for fault in flight.faults:
                print(f"seed {seed}: {fault} [{flight.result.outcome}: {flight.result.reason}]", flush=True)
    took_s = time.monotonic() - began_s
    said = ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items()))
    print(f"{asked.count} flights from seed {asked.first} on in {took_s:.0f} s: {said}; {went_home} with a way home")
    print(f"{wrong} with something wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
