"""Ctrl-C at random moments: the events are those of a run with what it cut short, without it, or with a part of its frames.

Segmenters with limbs, moves, followed moves, held poses, steps and repetitions get frames, changes and ends of takes.
An exception comes in the midst of each. Ids, revisions and takes are as documented all the time, and for a share of the
exceptions what is reported from then on is compared with runs from a snapshot made before.
"""

import argparse
import dis
import functools
import json
import random
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FrameType, TracebackType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import mossar_stream
from checks.random_takes import lives, moves_of
from mossar_adapters.demo import performance
from mossar_stream import BODY, Event, Segmenter, Settings, SettingsError, Skeleton, to_json

CORE = str(Path(mossar_stream.__file__).parent)
MOVES = ("punch_left", "squat", "wave_left", "rest:1.2", "kick_right", "squat", "squat", "stand:1")
FOLLOWING = 40  # frames that are compared after each exception
ROUNDS = 16  # exceptions in the life of a segmenter
READERS = ("move", "follow", "pose", "step", "phase")
LIVES_A_LINE = 100  # of what was found so far
SHOWN = 5  # failures that are printed


class Striking:
    """Raises KeyboardInterrupt in code of the core where the interpreter would: as functions begin, loops go on, calls return.

    Args:
        after: How many such places are passed over before.
    """

    def __init__(self, after: int) -> None:
        self.left, self.has_struck = after, False
        self._before: dict[int, str] = {}

    def __enter__(self) -> None:
        sys.settrace(self._call)

    def __exit__(self, kind: type[BaseException] | None, _: object, __: TracebackType | None) -> bool:
        sys.settrace(None)
        return kind is KeyboardInterrupt

    def _call(self, frame: FrameType, _event: str, _argument: object) -> Callable[..., Any] | None:
        if not frame.f_code.co_filename.startswith(CORE):
            return None
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        return self._opcode

    def _opcode(self, frame: FrameType, event: str, _argument: object) -> Callable[..., Any]:
        if event == "opcode":
            name = _names_of(frame.f_code)[frame.f_lasti]
            if name in ("NOP", "JUMP_FORWARD"):  # on the way to a return
                return self._opcode
            before, self._before[id(frame)] = self._before.get(id(frame)), name
            # A call of Python does not look before it returns, unless its arguments are unpacked.
            returned = before == "CALL_FUNCTION_EX" or (before == "CALL" and name != "RETURN_VALUE")
            if name in ("RESUME", "JUMP_BACKWARD") or returned:
                self.left -= 1
                if self.left == 0:
                    self.has_struck = True
                    raise KeyboardInterrupt
        return self._opcode


@functools.cache
def _names_of(code: CodeType) -> dict[int, str]:
    return {step.offset: step.opname for step in dis.get_instructions(code)} | dict.fromkeys([-1], "")


class Stage(NamedTuple):
    """What is pushed, and with which settings it begins."""

    skeleton: Skeleton
    positions: NDArray[np.float32]
    times: NDArray[np.float64]
    settings: Settings
    moves: int | None
    follow: bool


class Blow(NamedTuple):
    """What an exception cuts short."""

    name: str
    value: object
    frames: slice  # that are pushed, if it is `push`


@functools.cache
def _performance(seed: int) -> tuple[Skeleton, NDArray[np.float32], NDArray[np.float64]]:
    take = performance(seed, fps=60.0, seconds=60.0, moves=MOVES * 6)
    return take.skeleton, np.array(take.frames.positions, np.float32), np.array(take.frames.times)


def _stage(rng: random.Random) -> Stage:
    skeleton, positions, times = _performance(rng.randint(1, 6))
    begin = rng.randrange(len(times) - 1200)
    counts = rng.random() < 0.7
    settings = Settings(
        limbs=rng.random() < 0.7,
        repetitions=counts,
        phase=counts and rng.random() < 0.2,
        steps=rng.random() < 0.4,
        level=rng.choice(["motion", "motion", "posture", "cluster"]),
    )
    moves = rng.choice([None, 1, 3, 3, 3])
    return Stage(
        skeleton,
        positions[begin:],
        times[begin:].copy(),
        settings,
        moves,
        follow=moves is not None and rng.random() < 0.6,
    )


CHANGES: tuple[tuple[str, object], ...] = (
    *(("sig_threshold", value) for value in (0.02, 0.1)),
    *((name, value) for name in ("limbs", "repetitions", "steps") for value in (True, False)),
    ("remerge_window", 3),
    ("window", 0.2),
)
BLOWS: dict[str, Callable[[random.Random], object]] = {
    "end": lambda _: None,
    "reset": lambda _: None,
    "snapshot": lambda _: None,
    "level": lambda rng: rng.choice([0.1, 0.5, "motion", "posture"]),
    "change": lambda rng: rng.choice(CHANGES),
    "moves": lambda rng: rng.choice([None, 1, 3]),
    "follow": lambda rng: rng.choice([True, False]),
}


def _blows(rng: random.Random, stage: Stage) -> Iterator[Blow]:
    """Yield what is done; in between `FOLLOWING` frames are pushed."""
    begin = rng.randint(30, 200)
    yield Blow("begin", None, slice(0, begin))
    for _ in range(ROUNDS):
        name = rng.choice(["push"] * 10 + ["gap", *BLOWS])
        if name == "gap":
            stage.times[begin:] += rng.choice([-3.0, 3.0])
        if name in BLOWS:
            yield Blow(name, BLOWS[name](rng), slice(begin, begin))
        else:
            count = rng.choice([1, 1, 7, 16])
            yield Blow("push", None, slice(begin, begin + count))
            begin += count
        begin += FOLLOWING
        if begin + 100 > len(stage.times):
            return


def _done(one: Segmenter, stage: Stage, blow: Blow) -> list[Event]:
    """Do with a segmenter what a blow is about; a level may be refused."""
    try:
        return _done_or_refused(one, stage, blow)
    except SettingsError:
        return []


def _done_or_refused(one: Segmenter, stage: Stage, blow: Blow) -> list[Event]:
    match blow.name:
        case "push":
            single = blow.frames.stop - blow.frames.start == 1
            place = blow.frames.start if single else blow.frames
            return one.push(stage.positions[place], stage.times[place])
        case "end":
            return one.end_take()
        case "reset":
            return one.reset()
        case "snapshot":
            one.snapshot()
        case "level":
            one.level = blow.value  # type: ignore[assignment]
        case "change":
            change: tuple[str, object] = blow.value  # type: ignore[assignment]
            return one.change(**{change[0]: change[1]})
        case "moves":
            one.moves = None if blow.value is None else moves_of(int(str(blow.value)))
        case "follow":
            one.follow = bool(blow.value) and one.moves is not None
    return []


def _last_words(one: Segmenter) -> list[Event]:
    """Return what a segmenter reports if the take ends now, and leave it alone."""
    return Segmenter.restore(one.snapshot()).end_take()


def _as_json(events: list[Event]) -> list[bytes]:
    return [to_json(event) for event in events]


def _expected(blob: bytes, stage: Stage, blow: Blow) -> Iterator[list[bytes]]:
    """Yield what may be reported: with the blow, without it, and with the first of its frames."""
    begin, end = blow.frames.start, blow.frames.stop
    after = slice(end, end + FOLLOWING)
    for count in range(end - begin, -1, -1) if blow.name == "push" else (1, 0):
        one = Segmenter.restore(blob)
        events = []
        if count:
            frames = slice(begin, begin + count) if blow.name == "push" else blow.frames
            events = _done(one, stage, blow._replace(frames=frames))
        events += one.push(stage.positions[after], stage.times[after])
        yield _as_json(events + _last_words(one))


class Tally(NamedTuple):
    """What was found."""

    struck: Counter[str]
    compared: Counter[str]
    wrong: list[str]


def live(seed: int, tally: Tally, compared: float) -> None:
    """Let a segmenter live through some exceptions.

    Args:
        seed: Of the segmenter.
        tally: What is found is added to it.
        compared: Share of the exceptions after which the events are compared with those of other runs.
    """
    rng = random.Random(seed)  # noqa: S311 - no secret
    stage = _stage(rng)
    moves = None if stage.moves is None else moves_of(stage.moves)
    one = Segmenter(stage.skeleton, stage.settings, moves=moves, follow=stage.follow)
    blows = _blows(rng, stage)
    history = _as_json(_done(one, stage, next(blows)._replace(name="push")))
    for blow in blows:
        blob = one.snapshot() if rng.random() < compared else b""
        after = slice(blow.frames.stop, blow.frames.stop + FOLLOWING)
        strike = Striking(rng.choice([rng.randint(1, 30), rng.randint(1, 150), rng.randint(1, 1500)]))
        events: list[Event] = []
        with strike:
            events = _done(one, stage, blow)
        tally.struck[blow.name] += strike.has_struck
        if rng.random() < 0.3:
            one = Segmenter.restore(one.snapshot())
        events += one.push(stage.positions[after], stage.times[after])
        history += _as_json(events)
        if blob:
            tally.compared[blow.name] += strike.has_struck
            found = _as_json(events + _last_words(one))
            odd = _differences(
                found, _expected(blob, stage, blow), only_body=strike.has_struck and blow.name == "push"
            )
            tally.wrong.extend(f"seed {seed}, {blow}, struck {strike.has_struck}: {line}" for line in odd)
    tally.wrong.extend(f"seed {seed}: {line}" for line in lives(history + _as_json(one.end_take())))


def _differences(found: list[bytes], expected: Iterator[list[bytes]], *, only_body: bool) -> list[str]:
    """Return what of the events is as in none of the runs.

    Args:
        found: The events.
        expected: Those of the runs.
        only_body: Leave limbs and readers aside: they may lack the frame of the body in which the exception came.
    """
    own = _by_kind(found)
    whole = _by_kind(next(expected))
    kinds = {BODY} if only_body else {*own, *whole}
    left = {kind for kind in kinds if own.get(kind) != whole.get(kind)}
    while left and (lines := next(expected, None)) is not None:
        other = _by_kind(lines)
        left -= {kind for kind in left if own.get(kind) == other.get(kind)}
    odd = []
    for kind in sorted(left):
        mine, theirs = own.get(kind, []), whole.get(kind, [])
        extra = [line for line in mine if line not in theirs][:2]
        missing = [line for line in theirs if line not in mine][:2]
        odd.append(f"{len(mine)} {kind} events for {len(theirs)}; odd {extra}; missing {missing}")
    return odd


def _by_kind(lines: list[bytes]) -> dict[str, list[bytes]]:
    """Return events by what makes them: the body, a limb, or a reader."""
    kinds: dict[str, list[bytes]] = {}
    for line in lines:
        event = json.loads(line)
        kind = event["type"] if event["type"] in READERS else event.get("channel", BODY)
        kinds.setdefault(kind, []).append(line)
    return kinds


def main() -> int:
    """Interrupt segmenters, and print what is wrong."""
    parser = argparse.ArgumentParser(prog="python -m checks.interrupts", description=__doc__.split("\n")[0])
    parser.add_argument("--times", type=int, default=20_000, help="exceptions")
    parser.add_argument("--seed", type=int, default=1, help="of the first segmenter")
    parser.add_argument("--compared", type=float, default=0.15, help="share that is compared with other runs")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    begun, seed, tally = time.perf_counter(), options.seed, Tally(Counter(), Counter(), [])
    while sum(tally.struck.values()) < options.times:
        try:
            live(seed, tally, options.compared)
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
