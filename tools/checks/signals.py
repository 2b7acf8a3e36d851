"""Signals at random moments of the start of `mossar run`, cold and warm: each must end it, soon and in order.

    python -m checks.signals --starts 200 --cold 0.5 --seed 1
    python -m checks.signals --starts 20 --at-once 4 --longest-cold 6 --limit 10   # in a minute, beside other work
    python -m checks.signals --starts 1000 --results starts.jsonl --at-most 100    # ten times, whenever there is time

A start is cold when no kernel lies on disk, so that the signal comes while modules are imported or kernels compiled;
warm when all do, so that it comes while they are loaded, or when the run has begun. The package is copied, so that the
kernels of the installed one are left alone; they are copied for the warm starts, and what lacks is compiled before. Ends with status 1 if a start did not end within the limit, with
another status than 130 or 143, or with a traceback or words of a crash after the handlers are there.

With `--results` each start is written down, and those that stand there are not repeated: so a long check can be run in
parts, and the last line sums up all of them. What happens in start 17 depends on the seed and on 17 alone.
"""

import argparse
import os
import queue
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import msgspec

import mossar_adapters
import mossar_stream
import mossar_tools
from mossar_stream.jit.sources import digest

EXPECTED = {
    signal.SIGINT: (130, -signal.SIGINT),
    signal.SIGTERM: (143, -signal.SIGTERM),
}  # a status below 0: before there was a handler
PACKAGES = (mossar_stream, mossar_adapters, mossar_tools)
GRACE = 60.0  # s after which a process that does not end is killed
# What Python says, with status 1, of a SIGINT in its first hundredths of a second, before any code of ours runs.
PYTHON_STARTS = "Fatal Python error: init_"
BAD_WORDS = ("internal error", "Segmentation", "Fatal", "Exception ignored", "terminate called")
WARM = """
from mossar_stream import Segmenter, Settings, Skeleton, precompile
precompile()
Segmenter(Skeleton(("a", "b"), (-1, 0)), Settings(repetitions=True))
"""
COMMAND = ("run", "osc://127.0.0.1:0", "--to", "-")
MORE = ((), (), (), ("--repetitions",))  # kernels of their own


class Outcome(msgspec.Struct, frozen=True):
    """What became of one start."""

    index: int
    number: int  # of the signal
    cold: bool
    after: float  # s from the start to the signal
    took: float  # s from the signal to the end
    status: int
    words: str  # on standard error

    @property
    def is_early(self) -> bool:
        """Whether it ended before there was a handler."""
        return self.status < 0 or self.words.startswith(PYTHON_STARTS)

    def fault(self, limit: float) -> str:
        """Return what is wrong, nothing if all is well."""
        if self.took > limit:
            return f"took {self.took:.1f} s"
        if self.number == signal.SIGINT and self.words.startswith(PYTHON_STARTS):
            return ""
        if self.status not in EXPECTED[signal.Signals(self.number)]:
            return f"status {self.status}"
        # Before there was a handler, Python says where it was interrupted.
        bad = BAD_WORDS if self.status < 0 else (*BAD_WORDS, "Traceback")
        found = [word for word in bad if word in self.words]
        return f"said {found[0]!r}" if found else ""


def main() -> int:
    """Run the starts that the command line asks for; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--starts", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cold", type=float, default=0.5, help="share of the starts that find no kernels")
    parser.add_argument("--longest-cold", type=float, default=12.0, help="latest signal of a cold start, s")
    parser.add_argument("--longest-warm", type=float, default=2.5, help="latest signal of a warm start, s")
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
    signal.signal(signal.SIGINT, signal.default_int_handler)  # shells let what runs behind them ignore it
    outcomes = _read(options.results)
    with tempfile.TemporaryDirectory() as folder:
        for outcome in _starts(Path(folder), options, {outcome.index for outcome in outcomes}):
            outcomes.append(outcome)
            _write(options.results, outcome)
            fault = outcome.fault(options.limit)
            if fault:
                print(f"start {outcome.index}: {fault}: {outcome}", flush=True)
    return _report(outcomes, options.limit)


def _starts(folder: Path, options: argparse.Namespace, known: set[int]) -> Iterator[Outcome]:
    """Yield what becomes of the starts that are still to be made."""
    warm = _copies(folder / "warm", kernels=True)
    cold: queue.SimpleQueue[Path] = queue.SimpleQueue()  # a start removes the kernels of its place
    for place in range(options.at_once):
        cold.put(_copies(folder / f"cold{place}"))
    subprocess.run([sys.executable, "-c", WARM], env=_environment(warm), check=True)  # noqa: S603
    due = [index for index in range(options.starts) if index not in known]
    with ThreadPoolExecutor(options.at_once) as pool:
        try:
            made = [
                pool.submit(_start_as_planned, index, options, warm, cold) for index in due[: options.at_most]
            ]
            yield from (one.result() for one in as_completed(made))
        finally:
            pool.shutdown(cancel_futures=True)


def _start_as_planned(
    index: int, options: argparse.Namespace, warm: Path, cold: "queue.SimpleQueue[Path]"
) -> Outcome:
    """Make a start: what happens in it follows from the seed and its index."""
    rng = random.Random(f"{options.seed} {index}")  # noqa: S311 - repeatable, not secret
    is_cold = rng.random() < options.cold
    longest = options.longest_cold if is_cold else options.longest_warm
    number, after = rng.choice(list(EXPECTED)), rng.uniform(0.0, longest)
    if not is_cold:
        return start(warm, index, number, after, cold=False)
    place = cold.get()
    try:
        return start(place, index, number, after, cold=True)
    finally:
        cold.put(place)


def start(place: Path, index: int, number: signal.Signals, after: float, *, cold: bool) -> Outcome:
    """Start a run, send it a signal, and see what becomes of it.

    Args:
        place: Where the copied packages are.
        index: Of the start.
        number: Which signal.
        after: s.
        cold: Whether kernels are removed before.
    """
    if cold:
        for folder in place.rglob("kernels-*"):
            shutil.rmtree(folder)
    command = [sys.executable, "-m", "mossar_tools", *COMMAND, *MORE[index % len(MORE)]]
    process = subprocess.Popen(  # noqa: S603 - our own interpreter
        command,
        env=_environment(place),
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
    return Outcome(index, number, cold, after, time.monotonic() - sent, process.returncode, words)


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


def _copies(folder: Path, *, kernels: bool = False) -> Path:
    """Return a folder with copies of the packages, with the kernels of these sources if they are wanted."""
    kept = {f"kernels-{digest()}"} if kernels else set()
    for package in PACKAGES:
        source = Path(str(package.__file__)).parent
        shutil.copytree(source, folder / source.name, ignore=_all_kernels_but(kept))
    return folder


def _all_kernels_but(kept: set[str]) -> Callable[[str, list[str]], list[str]]:
    return lambda _, names: [name for name in names if name.startswith("kernels-") and name not in kept]


def _environment(place: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(place)}


def _report(outcomes: list[Outcome], limit: float) -> int:
    for cold in (True, False):
        own = [outcome for outcome in outcomes if outcome.cold == cold]
        if own:
            faults = sum(bool(outcome.fault(limit)) for outcome in own)
            early = sum(outcome.is_early for outcome in own)
            slowest = max(outcome.took for outcome in own)
            print(
                f"{'cold' if cold else 'warm'}: {len(own)} starts, {faults} faults, slowest end {slowest:.2f} s, "
                f"{early} before there was a handler"
            )
    return int(any(outcome.fault(limit) for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
