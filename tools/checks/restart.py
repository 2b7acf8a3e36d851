"""Kill and restart: `python -m checks.restart --times 50`.

A run of the built-in performers is killed (-9) at a random moment and started again. At the end, the
events of a consumer, without those that repeat an id and a rev, must equal those of an undisturbed run; so must the file
of events, without any dropped. Every other time that there is a snapshot the power goes, too: the file of events is
then cut at a random place. It must lack the lost bytes and nothing else, and the second run must log the loss.
"""

import argparse
import json
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec

from mossar_adapters.demo import DemoSource
from mossar_adapters.files import MskWriter
from mossar_adapters.pipeline import read_snapshot
from mossar_adapters.source import Meta
from mossar_stream import Frames

SPEED = 5.0  # times real time, of the runs that are killed
EVERY = 0.3  # s between two snapshots
_CLOCK = ("stalled", "resumed")  # depend on the machine, not on the motion


class Moment(msgspec.Struct, frozen=True):
    """Result of one kill.

    Args:
        seconds: When the run was killed, s after it was started.
        frames: Frames that its snapshot had used, None without a snapshot.
        repeated: Events that were heard twice.
        equal: Whether the consumer heard the right events.
        file_equal: Whether the file of events is right.
        lost: Bytes of it that the snapshot counts on and the disk lost, None if the power stayed.
        told: Whether the second run spoke of them, as it must if there are any.
    """

    seconds: float
    frames: int | None
    repeated: int
    equal: bool
    file_equal: bool
    lost: int | None
    told: bool

    @property
    def right(self) -> bool:
        """Whether all was as it must be."""
        return self.equal and self.file_equal and self.told == bool(self.lost)


class _Cut(msgspec.Struct, frozen=True):
    """The rest of a file of events after a power cut."""

    lost: int | None = None  # bytes that the snapshot counts on
    lines: tuple[str, ...] = ()  # lines in them


def main() -> int:
    """Kill and restart a number of times, print a line for each, and return 1 if a set differed."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.restart",
        description="Kill runs with -9, cut the power, and restart them; no event that was kept may be lost or changed.",
    )
    parser.add_argument("--times", metavar="N", type=int, default=50)
    parser.add_argument("--seed", metavar="S", type=int, default=1, help="of the moments")
    parser.add_argument("--seconds", metavar="S", type=float, default=30.0, help="of motion")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        equal = 0
        for i, moment in enumerate(killed_at_random(Path(folder), given.times, given.seconds, given.seed), 1):
            equal += moment.right
            place = (
                "before the first snapshot" if moment.frames is None else f"snapshot at frame {moment.frames}"
            )
            print(
                f"{i:>3}: killed after {moment.seconds:.2f} s, {place}, {moment.repeated} events repeated"
                f"{'' if moment.lost is None else f', {moment.lost} bytes lost'}:"
                f" {'as it must be' if moment.right else 'DIFFERENT'}",
                flush=True,
            )
    print(f"{equal} of {given.times} event sets are as they must be")
    return 0 if equal == given.times else 1


def killed_at_random(folder: Path, times: int, seconds: float, seed: int) -> Iterator[Moment]:
    """Kill runs at random moments, let each come to its end, and yield how it went.

    Args:
        folder: For recordings, events and snapshots.
        times: How many.
        seconds: Of motion in the recording.
        seed: Of the moments.
    """
    take = folder / "take.msk"
    with MskWriter(take) as writer:
        for item in DemoSource(5, performers=2, seconds=seconds, speed="max").items():
            if isinstance(item, Meta | Frames):
                writer.write(item)
    started = time.monotonic()
    whole = _lines(_run(folder, "whole", [take, "--speed", SPEED]))
    longest = time.monotonic() - started
    rng = random.Random(seed)  # noqa: S311 - not for secrets
    power_goes = True
    while times:
        share = rng.random() if power_goes else None
        moment = _killed(folder, take, whole, rng.uniform(0.0, longest), share)
        if moment is not None:
            times -= 1
            power_goes ^= moment.frames is not None
            yield moment


def _killed(
    folder: Path, take: Path, whole: Sequence[str], seconds: float, share: float | None
) -> Moment | None:
    """Run, kill after so many seconds, run again to the end; return None if the first run was quicker.

    Args:
        folder: Of the files.
        take: The recording.
        whole: Lines of an undisturbed run.
        seconds: When the run is killed.
        share: Of the file of events that a power cut leaves, None for no such cut.
    """
    for name in ("state", "state.new", "events.jsonl"):
        (folder / name).unlink(missing_ok=True)
    again = [take, "--to", "-", "--to", folder / "events.jsonl", "--snapshot", folder / "state"]
    again += ["--snapshot-every", EVERY]
    first = _run(folder, "first", [*again, "--speed", SPEED], kill_after=seconds)
    kept = read_snapshot(folder / "state")
    if kept is not None and kept.complete:
        return None
    counted_on = kept.sinks.get(str(folder / "events.jsonl"), 0) if kept else None
    cut = _Cut() if share is None or counted_on is None else _cut(folder / "events.jsonl", share, counted_on)
    second = _run(folder, "second", [*again, "--speed", "max"])
    heard = [*_lines(first), *_lines(second)]
    return Moment(
        seconds,
        sum(kept.sources[0].frames.values()) if kept else None,
        len(heard) - len({_key(line) for line in heard}),
        {_key(line): line for line in heard} == {_key(line): line for line in whole},
        sorted([*_lines(folder / "events.jsonl"), *cut.lines]) == sorted(whole),
        cut.lost,
        b"are lost" in (folder / "second.err").read_bytes(),
    )


def _cut(events: Path, share: float, counted_on: int) -> _Cut:
    """Leave a share of a file, and return the lost bytes that the snapshot refers to."""
    data = events.read_bytes()
    left = round(share * len(data))
    events.write_bytes(data[:left])
    if left >= counted_on:
        return _Cut(0)
    whole = data[:left].rfind(b"\n") + 1  # the next run goes on behind the last whole line
    gone = data[whole:counted_on].decode().split("\n")[:-1]
    return _Cut(
        counted_on - whole, tuple(line for line in gone if json.loads(line).get("event") not in _CLOCK)
    )


def _run(folder: Path, name: str, arguments: Sequence[object], kill_after: float | None = None) -> Path:
    """Run `mossar run`; return the file with its standard output."""
    out = folder / f"{name}.out"
    command = [sys.executable, "-m", "mossar_tools", "run", "--run-id", "restart", *map(str, arguments)]
    errors = out.with_suffix(".err")
    with (
        out.open("wb") as file,
        errors.open("wb") as said,
        subprocess.Popen(command, stdout=file, stderr=said) as running,  # noqa: S603 - our own
    ):
        try:
            status = running.wait(kill_after)
        except subprocess.TimeoutExpired:
            running.kill()
            return out
    if status != 0:
        raise SystemExit(f"mossar run ended with status {status}: {errors.read_text()}")
    return out


def _lines(path: Path) -> list[str]:
    """Return the whole lines of a file of events, without those about the machine's speed."""
    lines = path.read_text(encoding="utf-8").split("\n")[:-1] if path.exists() else []
    return [line for line in lines if json.loads(line).get("event") not in _CLOCK]


def _key(line: str) -> tuple[Any, ...]:
    """Return the key of an event: two lines with the same key are the same event."""
    event = json.loads(line)
    if "id" in event:
        return event["type"], event["id"], event.get("rev", 1)  # an activity has one message
    return event["type"], event["performer"], event["take"], event["event"]


if __name__ == "__main__":
    sys.exit(main())
