"""The program: `python -m checks.interrupts --times 20000`."""

import argparse
import sys
import time
import traceback
import warnings
from collections import Counter

from checks import interrupts
from checks.interrupts.alone import Tally, live
from checks.interrupts.pools import live_in_pool

LIVES_A_LINE = 100  # of the findings so far
SHOWN = 5  # failures that are printed


def main() -> int:
    """Interrupt segmenters, and print faults."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.interrupts", description=interrupts.__doc__.split("\n")[0]
    )
    parser.add_argument("--times", type=int, default=20_000, help="exceptions")
    parser.add_argument("--seed", type=int, default=1, help="of the first segmenter")
    parser.add_argument("--pools", type=float, default=0.3, help="share of lives that are those of a pool")
    parser.add_argument("--compared", type=float, default=0.15, help="share that is compared with other runs")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    begun, seed, tally = time.perf_counter(), options.seed, Tally(Counter(), Counter(), [])
    while sum(tally.struck.values()) < options.times:
        try:
            is_pool = seed * options.pools % 1.0 < options.pools  # evenly among the seeds
            (live_in_pool if is_pool else live)(seed, tally, options.compared)
        except Exception:  # noqa: BLE001 - finding these is the point
            tally.wrong.append(f"seed {seed}: {traceback.format_exc(limit=-4)}")
        seed += 1
        if seed % LIVES_A_LINE == 0:
            print(f"{sum(tally.struck.values())} exceptions, {len(tally.wrong)} wrong", flush=True)
    for line in tally.wrong[:SHOWN]:
        print(line[:1500])
    print(
        f"{sum(tally.struck.values())} exceptions in {seed - options.seed} lives, {dict(tally.struck)}, "
        f"{sum(tally.compared.values())} compared: "
        f"{len(tally.wrong)} wrong ({time.perf_counter() - begun:.0f} s)"
    )
    return 1 if tally.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
