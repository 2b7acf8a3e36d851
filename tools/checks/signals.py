"""Signals at random moments of the start of `mossar run`: each must end it, soon and in order.

    python -m checks.signals --starts 200 --seed 1
    python -m checks.signals --starts 20 --at-once 4 --limit 10                    # beside other work
    python -m checks.signals --starts 1000 --results starts.jsonl --at-most 100    # ten times, whenever there is time

The signal comes while modules are imported, or when the run has begun. Ends with status 1 if a start did not end within
the limit, with another status than 130 or 143, or with a traceback or words of a crash after the handlers are there.

With `--results` each start is written down and not repeated. A long check can thus be run in parts; the last line sums up
all of them. The course of start 17 depends on the seed and on 17 alone.
"""

import argparse
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import msgspec

# A status below 0: before there was a handler.
EXPECTED = {
    signal.SIGINT: (130, -signal.SIGINT),
    signal.SIGTERM: (143, -signal.SIGTERM),
}
GRACE = 60.0  # s after which a process that does not end is killed
# Messages of Python, with status 1, about a SIGINT in its first hundredths of a second, before any code of ours runs.
PYTHON_STARTS = ("Fatal Python error: init_", "Could not import runpy module")
# Messages of Python about a SIGINT that it discards, as no handler of ours does: it came while a module's lock was removed.
PYTHON_DISCARDS = "Exception ignored in: <function _get_module_lock"
BAD_WORDS = ("internal error", "Segmentation", "Fatal", "Exception ignored", "terminate called")
COMMAND = ("run", "osc://127.0.0.1:0", "--to", "-")


class Outcome(msgspec.Struct, frozen=True):
    """Outcome of one start."""

    index: int
    number: int  # of the signal
    after: float  # s from the start to the signal
    took: float  # s from the signal to the end
    status: int
    words: str  # on standard error

    @property
    def is_early(self) -> bool:
        """Whether it ended before there was a handler."""
        return self.status < 0 or self.words.startswith(PYTHON_STARTS) or self.is_lost

    @property
    def is_lost(self) -> bool:
        """Whether Python discarded the signal before there was a handler, so that the run went on."""
        return self.number == signal.SIGINT and PYTHON_DISCARDS in self.words

    def fault(self, limit: float) -> str:
        """Return the fault, empty if there is none."""
        if self.is_lost:
            return ""
        if self.took > limit:
            return f"took {self.took:.1f} s"
        if self.number == signal.SIGINT and self.words.startswith(PYTHON_STARTS):
            return ""
        if self.status not in EXPECTED[signal.Signals(self.number)]:
            return f"status {self.status}"
        # Before there was a handler, Python prints the place of the interrupt.
        bad = BAD_WORDS if self.status < 0 else (*BAD_WORDS, "Traceback")
        found = [word for word in bad if word in self.words]
        return f"said {found[0]!r}" if found else ""


def main() -> int:
    """Run the starts of the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--starts", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--latest", type=float, default=1.5, help="latest signal, s")
    parser.add_argument(
        "--at-once",
        metavar="N",
        type=int,
        default=1,
        help="starts that run side by side; their ends take longer",
    )
    parser.add_argument("--limit", type=float, default=2.0, help="within which a start must end, s")
    parser.add_argument(
        "--results", metavar="FILE", type=Path, help="write each start here, and go on behind them"
    )
    parser.add_argument("--at-most", metavar="N", type=int, help="starts of this call; the others remain")
    options = parser.parse_args()
    signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # shells make programs in the background ignore it
    outcomes = _read(options.results)
    for outcome in _starts(options, {outcome.index for outcome in outcomes}):
        outcomes.append(outcome)
        _write(options.results, outcome)
        fault = outcome.fault(options.limit)
        if fault:
            print(f"start {outcome.index}: {fault}: {outcome}", flush=True)
    return _report(outcomes, options.limit)


def _starts(options: argparse.Namespace, known: set[int]) -> Iterator[Outcome]:
    """Yield the outcomes of the starts that are still to be made."""
    due = [index for index in range(options.starts) if index not in known]
    with ThreadPoolExecutor(options.at_once) as pool:
        try:
            made = [pool.submit(_start_as_planned, index, options) for index in due[: options.at_most]]
            yield from (one.result() for one in as_completed(made))
        finally:
            pool.shutdown(cancel_futures=True)


def _start_as_planned(index: int, options: argparse.Namespace) -> Outcome:
    """Make a start, determined by the seed and its index."""
    rng = random.Random(f"{options.seed} {index}")  # noqa: S311 - repeatable, not secret
    return start(index, rng.choice(list(EXPECTED)), rng.uniform(0.0, options.latest))


def start(index: int, number: signal.Signals, after: float) -> Outcome:
    """Start a run, send it a signal, and return the outcome.

    Args:
        index: Of the start.
        number: The signal.
        after: s.
    """
    process = subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, "-m", "mossar_tools", *COMMAND],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(after)
    sent = time.monotonic()
    process.send_signal(number)
    try:
        _, words = process.communicate(timeout=GRACE)
    except subprocess.TimeoutExpired:
        process.kill()
        _, words = process.communicate()
    return Outcome(index, number, after, time.monotonic() - sent, process.returncode, words)


def _read(results: Path | None) -> list[Outcome]:
    """Return the starts of former calls; a line that a crash cut off is left out, and made again."""
    if results is None or not results.exists():
        return []
    lines = results.read_bytes().split(b"\n")[:-1]
    return [msgspec.json.decode(line, type=Outcome) for line in lines if line]


def _write(results: Path | None, outcome: Outcome) -> None:
    if results is not None:
        with results.open("ab") as file:
            file.write(msgspec.json.encode(outcome) + b"\n")


def _report(outcomes: list[Outcome], limit: float) -> int:
    faults = sum(bool(outcome.fault(limit)) for outcome in outcomes)
    early = sum(outcome.is_early for outcome in outcomes)
    slowest = max((outcome.took for outcome in outcomes if not outcome.is_lost), default=0.0)
    print(
        f"{len(outcomes)} starts, {faults} faults, slowest end {slowest:.2f} s, "
        f"{early} before there was a handler, "
        f"{sum(outcome.is_lost for outcome in outcomes)} of them discarded by Python"
    )
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
