"""One segmenter, and its state after exceptions."""

import functools
import json
import random
from collections import Counter
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from checks.interrupts.striking import Striking
from checks.random_takes import lives, moves_of
from mossar_adapters.demo import performance
from mossar_stream import BODY, Event, Segmenter, Settings, SettingsError, Skeleton, to_json

MOVES = ("punch_left", "squat", "wave_left", "rest:1.2", "kick_right", "squat", "squat", "stand:1")
FOLLOWING = 40  # frames that are compared after each exception
ROUNDS = 16  # exceptions in the life of a segmenter
READERS = ("move", "follow", "pose", "step", "phase")


class Stage(NamedTuple):
    """The pushed frames, and the initial settings."""

    skeleton: Skeleton
    positions: NDArray[np.float32]
    times: NDArray[np.float64]
    settings: Settings
    moves: int | None
    follow: bool


class Blow(NamedTuple):
    """A call that an exception interrupts."""

    name: str
    value: object
    frames: slice  # that are pushed, if it is `push`


@functools.cache
def _performance(seed: int) -> tuple[Skeleton, NDArray[np.float32], NDArray[np.float64]]:
    take = performance(seed, fps=60.0, seconds=60.0, moves=MOVES * 6)
    return take.skeleton, np.array(take.frames.positions, np.float32), np.array(take.frames.times)


def stage_of(rng: random.Random) -> Stage:
    """Return random frames and settings for a segmenter, or a pool."""
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
    """Yield the calls; in between `FOLLOWING` frames are pushed."""
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
    """Carry out the call of a blow on a segmenter; a level may be refused."""
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
    """Return the events of a segmenter if the take ended now, without changing it."""
    return Segmenter.restore(one.snapshot()).end_take()


def as_json(events: list[Event]) -> list[bytes]:
    """Return a line for each event."""
    return [to_json(event) for event in events]


def _expected(blob: bytes, stage: Stage, blow: Blow) -> Iterator[list[bytes]]:
    """Yield the permitted events: with the blow, without it, and with the first of its frames."""
    begin, end = blow.frames.start, blow.frames.stop
    after = slice(end, end + FOLLOWING)
    for count in range(end - begin, -1, -1) if blow.name == "push" else (1, 0):
        one = Segmenter.restore(blob)
        events = []
        if count:
            frames = slice(begin, begin + count) if blow.name == "push" else blow.frames
            events = _done(one, stage, blow._replace(frames=frames))
        events += one.push(stage.positions[after], stage.times[after])
        yield as_json(events + _last_words(one))


class Tally(NamedTuple):
    """Findings."""

    struck: Counter[str]
    compared: Counter[str]
    wrong: list[str]


def live(seed: int, tally: Tally, compared: float) -> None:
    """Run a segmenter through some exceptions.

    Args:
        seed: Of the segmenter.
        tally: Findings are added to it.
        compared: Share of the exceptions after which the events are compared with those of other runs.
    """
    rng = random.Random(seed)  # noqa: S311 - no secret
    stage = stage_of(rng)
    moves = None if stage.moves is None else moves_of(stage.moves)
    one = Segmenter(stage.skeleton, stage.settings, moves=moves, follow=stage.follow)
    blows = _blows(rng, stage)
    history = as_json(_done(one, stage, next(blows)._replace(name="push")))
    for blow in blows:
        blob = one.snapshot() if rng.random() < compared else b""
        after = slice(blow.frames.stop, blow.frames.stop + FOLLOWING)
        strike = Striking(rng.choice([rng.randint(1, 5), rng.randint(1, 40), rng.randint(1, 1000)]))
        events: list[Event] = []
        with strike:
            events = _done(one, stage, blow)
        tally.struck[blow.name] += strike.has_struck
        if rng.random() < 0.3:
            one = Segmenter.restore(one.snapshot())
        events += one.push(stage.positions[after], stage.times[after])
        history += as_json(events)
        if blob:
            tally.compared[blow.name] += strike.has_struck
            found = as_json(events + _last_words(one))
            odd = differences(
                found, _expected(blob, stage, blow), only_body=strike.has_struck and blow.name == "push"
            )
            tally.wrong.extend(f"seed {seed}, {blow}, struck {strike.has_struck}: {line}" for line in odd)
    tally.wrong.extend(f"seed {seed}: {line}" for line in lives(history + as_json(one.end_take())))


def differences(found: list[bytes], expected: Iterator[list[bytes]], *, only_body: bool) -> list[str]:
    """Return the events that differ from all of the runs.

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
    """Return events by their origin: the body, a limb, or a reader."""
    kinds: dict[str, list[bytes]] = {}
    for line in lines:
        event = json.loads(line)
        kind = event["type"] if event["type"] in READERS else event.get("channel", BODY)
        kinds.setdefault(kind, []).append(line)
    return kinds
