"""Signals at random moments of the start of `mossar run`, cold and warm: each must end it, soon and in order.

    python -m checks.signals --starts 200 --cold 0.5 --seed 1

A start is cold when no kernel lies on disk, so that the signal comes while modules are imported or kernels compiled;
warm when all do, so that it comes while they are loaded, or when the run has begun. The package is copied, so that
the kernels of the installed one are left alone. Ends with status 1 if a start did not end within the limit, with
another status than 130 or 143, or with more than one line on standard error after the handlers are there.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import mossar_adapters
import mossar_stream
import mossar_tools

EXPECTED = {
    signal.SIGINT: (130, -signal.SIGINT),
    signal.SIGTERM: (143, -signal.SIGTERM),
}  # a status below 0: before there was a handler
PACKAGES = (mossar_stream, mossar_adapters, mossar_tools)
GRACE = 60.0  # s after which a process that does not end is killed
BAD_WORDS = ("internal error", "Segmentation", "Fatal", "Exception ignored", "terminate called")


class Outcome(NamedTuple):
    """What became of one start."""

    number: signal.Signals
    cold: bool
    after: float  # s from the start to the signal
    took: float  # s from the signal to the end
    status: int
    words: str  # on standard error

    def fault(self, limit: float) -> str:
        """Return what is wrong, nothing if all is well."""
        if self.took > limit:
            return f"took {self.took:.1f} s"
        if self.status not in EXPECTED[self.number]:
            return f"status {self.status}"
        found = [word for word in BAD_WORDS if word in self.words]
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
    parser.add_argument("--limit", type=float, default=2.0, help="within which a start must end, s")
    options = parser.parse_args()
    rng = random.Random(options.seed)  # noqa: S311 - repeatable, not secret
    with tempfile.TemporaryDirectory() as folder:
        place = _copies(Path(folder))
        outcomes = []
        for index in range(options.starts):
            cold = rng.random() < options.cold
            longest = options.longest_cold if cold else options.longest_warm
            number = rng.choice(list(EXPECTED))
            outcomes.append(start(place, number, rng.uniform(0.0, longest), cold=cold))
            fault = outcomes[-1].fault(options.limit)
            if fault:
                print(f"start {index}: {fault}: {outcomes[-1]}", flush=True)
    return _report(outcomes, options.limit)


def start(place: Path, number: signal.Signals, after: float, *, cold: bool) -> Outcome:
    """Start a run, send it a signal, and see what becomes of it.

    Args:
        place: Where the copied packages are.
        number: Which signal.
        after: s.
        cold: Whether kernels are removed before.
    """
    if cold:
        for folder in place.rglob("kernels-*"):
            shutil.rmtree(folder)
    elif not any(place.rglob("kernels-*/*/*.nbc")):
        subprocess.run([sys.executable, "-c", WARM], env=_environment(place), check=True)  # noqa: S603
    command = [sys.executable, "-m", "mossar_tools", "run", "osc://127.0.0.1:0", "--to", "-"]
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
    return Outcome(number, cold, after, time.monotonic() - sent, process.returncode, words)


WARM = "import mossar_stream; mossar_stream.precompile()"


def _copies(folder: Path) -> Path:
    for package in PACKAGES:
        source = Path(str(package.__file__)).parent
        ignored = shutil.ignore_patterns("kernels-*")
        shutil.copytree(source, folder / source.name, ignore=ignored)
    return folder


def _environment(place: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(place)}


def _report(outcomes: list[Outcome], limit: float) -> int:
    for cold in (True, False):
        own = [outcome for outcome in outcomes if outcome.cold == cold]
        if own:
            faults = sum(bool(outcome.fault(limit)) for outcome in own)
            early = sum(outcome.status < 0 for outcome in own)
            slowest = max(outcome.took for outcome in own)
            print(
                f"{'cold' if cold else 'warm'}: {len(own)} starts, {faults} faults, slowest end {slowest:.2f} s, "
                f"{early} before there was a handler"
            )
    return int(any(outcome.fault(limit) for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
