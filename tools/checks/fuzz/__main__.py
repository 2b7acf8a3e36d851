"""The program: `python -m checks.fuzz --inputs 100000 --seed 1`."""

import argparse
import faulthandler
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from checks.fuzz.guard import memory, set_limits
from checks.fuzz.target import Tally, Target, run_round

_PIECES = 200  # turns in which the targets get their inputs, so that a run cut short has fed all of them


def main() -> int:
    """Feed the targets, print a line for each, and return 1 if something failed."""
    given = _arguments()
    faulthandler.enable()
    targets = _chosen(_targets(given.samples), given.target)
    tallies = {target.name: Tally() for target in targets}
    set_limits()
    before = memory()
    if given.round is not None:
        for target in targets:
            run_round(target, given.seed, given.round, target.round, tallies[target.name])
    else:
        _run(targets, tallies, given.inputs, given.seed, given.seconds)
    _print(tallies, memory() - before)
    if given.keep is not None:
        _save(given.keep, tallies)
    return 1 if any(tally.failed for tally in tallies.values()) else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m checks.fuzz", description="Feed damaged input to everything that reads."
    )
    parser.add_argument("--inputs", metavar="N", type=int, default=100_000, help="in all (default: 100000)")
    parser.add_argument("--seconds", metavar="S", type=float, help="stop after so much time")
    parser.add_argument(
        "--seed", metavar="S", type=int, default=1, help="the same seed makes the same inputs"
    )
    parser.add_argument("--target", metavar="T", action="append", help="only targets whose name begins so")
    parser.add_argument("--round", metavar="R", type=int, help="only this round, as a crash names it")
    parser.add_argument("--samples", metavar="DIR", type=Path, help="recordings to be damaged, too")
    parser.add_argument("--keep", metavar="DIR", type=Path, help="write inputs that made something fail here")
    return parser.parse_args()


def _targets(samples: Path | None) -> list[Target]:
    try:
        from checks.fuzz.targets import all_targets
    except ModuleNotFoundError as error:
        sys.exit(f"fuzzing needs {error.name}: pip install -e . --group dev")
    return all_targets(samples)


def _chosen(targets: Sequence[Target], names: Sequence[str] | None) -> list[Target]:
    chosen = [t for t in targets if names is None or any(t.name.startswith(name) for name in names)]
    if not chosen:
        sys.exit(f"no such target; there are {', '.join(target.name for target in targets)}")
    return chosen


def _run(
    targets: Sequence[Target], tallies: dict[str, Tally], inputs: int, seed: int, seconds: float | None
) -> None:
    """Feed all targets, each its share, in turns."""
    end = float("inf") if seconds is None else time.monotonic() + seconds
    whole = sum(target.share for target in targets)
    rounds = {target.name: 0 for target in targets}
    for piece in range(1, _PIECES + 1):
        for target in targets:
            tally, share = tallies[target.name], round(inputs * target.share / whole)
            due = share * piece / _PIECES if piece < _PIECES else share
            # A first round for every target, then whole rounds until the last turn.
            while tally.inputs < share and (
                not tally.inputs or tally.inputs + target.round <= due or piece == _PIECES
            ):
                if time.monotonic() >= end:
                    return
                count = min(target.round, share - tally.inputs)
                run_round(target, seed, rounds[target.name], count, tally)
                rounds[target.name] += 1


def _print(tallies: dict[str, Tally], growth: int) -> None:
    print(f"{'target':<18}{'inputs':>10}{'refused':>10}{'crashes':>9}{'per s':>9}{'slowest':>11}")
    for name, tally in tallies.items():
        rate = tally.inputs / tally.seconds if tally.seconds else 0.0
        print(
            f"{name:<18}{tally.inputs:>10}{tally.refused:>10}{tally.failed:>9}{rate:>9.0f}"
            f"{tally.slowest * 1000:>8.1f} ms"
        )
        for crash in tally.crashes:
            print(
                f"  round {crash.round}: {crash.kind}\n    {crash.data[:200]!r}\n{crash.trace}",
                file=sys.stderr,
            )
    inputs, failed = sum(t.inputs for t in tallies.values()), sum(t.failed for t in tallies.values())
    seconds = sum(t.seconds for t in tallies.values())
    print(
        f"{inputs} inputs, {failed} crashes, {seconds:.0f} s; memory grew by {growth / 2**20:.1f} MB",
        flush=True,
    )


def _save(folder: Path, tallies: dict[str, Tally]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, tally in tallies.items():
        for i, crash in enumerate(tally.crashes):
            (folder / f"{name.replace(' ', '_')}-{i}").write_bytes(crash.data)


if __name__ == "__main__":
    sys.exit(main())
