"""Random takes, all features at once: however frames are cut and snapshots taken, the events are the same, and each id lives as documented.

A take is one of the built-in performer with faults of sensors, clocks and receivers, random settings, and changes in
mid-take. Its events in chunks of 64 are compared with those of single frames, chunks of 7 and 1000, and random ones with
snapshots between them, and of pools of two performers. As a recording it is segmented in one chunk and frame by frame.

Every third seed plays a crowd besides, whose ids get slots as with `--people`: no two people share a slot at a time, a
snapshot of the slots changes no known id, and the pool's events hang neither on how frames are cut nor on its snapshots.
"""

import argparse
import itertools
import json
import random
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from checks.random_crowds import in_slots, random_crowd
from mossar_adapters.demo import performance
from mossar_stream import (
    BODY,
    Event,
    FrameError,
    Frames,
    Moves,
    MovesError,
    Performers,
    Segmenter,
    Settings,
    SettingsError,
    Skeleton,
    segment_recording,
    to_json,
)

MOVES = (
    None,
    ("rest:1", "punch_left", "squat", "kick_right"),
    ("wave_left", "squat", "rest:0.5"),
    ("squat",),
    ("walk", "walk", "stand:1"),
)
TAUGHT = (("punch", "punch_left"), ("kick", "kick_right"), ("squat", "squat"))
CHANGES: tuple[tuple[str, tuple[object, ...]], ...] = (
    ("level", ("motion", "posture", "cluster", 0.1, 0.5)),
    ("limbs", (True, False)),
    ("repetitions", (True, False)),
    ("moves", (None, 1, 3)),
    ("poses", (True, False)),
    ("follow", ((), True)),
    ("steps", (True, False)),
    ("max_gap", (0.1,)),
    ("max_pause", (0.2, 2.0)),
    ("reset", (None,)),
    ("end", (None,)),
    ("remerge_window", (1, 3, 20)),
)
# Kinds of events, each of which occurs in so many takes.
TYPES = [
    "key_frame",
    "segment",
    "activity",
    "stream",
    "repetition",
    "phase",
    "move",
    "follow",
    "pose",
    "step",
]
ENOUGH = 100
LONGEST_CROWD = 4.0  # s
CROWDED = 3  # one of so many takes has a crowd besides
# Statuses after which no message comes about an id.
LAST_WORDS = {
    "key_frame": {"final", "withdrawn"},
    "move": {"final", "withdrawn"},
    "follow": {"done", "left"},
    "pose": {"left"},
}
SHOWN = 5  # failures that are printed


class Take(NamedTuple):
    """A random take, and its changes, by frame."""

    skeleton: Skeleton
    positions: NDArray[Any]
    times: NDArray[np.float64]
    settings: Settings
    moves: int | None
    follows: bool
    changes: dict[int, tuple[str, object]]


_taught: dict[tuple[int, bool], Moves] = {}


def moves_of(count: int, *, poses: bool = True) -> Moves:
    """Return so many moves, and standing as a pose that is held."""
    if (count, poses) not in _taught:
        standing = performance(3, seconds=2.0, moves=["stand:2"])
        made = Moves(standing.skeleton)
        if poses:
            made.add_pose("standing", standing.frames.positions, fps=60, hold=0.3)
        for k, (name, move) in enumerate(TAUGHT[:count]):
            shown = performance(7 + k, seconds=4.0, moves=["rest:1", move, "rest:1"])
            made.add(name, shown.frames.positions, fps=60)
        _taught[count, poses] = made
    return _taught[count, poses]


def random_take(seed: int, seconds: float) -> Take:
    """Return the take of a seed, at most so long."""
    rng, noise = random.Random(seed), np.random.default_rng(seed)  # noqa: S311 - no secret
    fps = rng.choice([15, 30, 30, 60, 60, 120])
    chosen = rng.choice(MOVES)
    shown = None if chosen is None else list(itertools.islice(itertools.cycle(chosen), 20))
    take = performance(seed, fps=float(fps), seconds=rng.uniform(2.0, seconds), moves=shown)
    positions = _spoilt(np.array(take.frames.positions, np.float64), fps, rng, noise)
    times = _spoilt_times(np.array(take.frames.times), fps, rng, noise)
    if rng.random() < 0.6:
        positions = positions.astype(np.float32)
    chosen_settings: dict[str, object] = {
        "level": rng.choice(["motion", "motion", "posture", "cluster", 0.3]),
        "limbs": rng.random() < 0.7,
        "repetitions": rng.random() < 0.6,
    }
    chosen_settings["steps"] = rng.random() < 0.3
    chosen_settings["phase"] = chosen_settings["repetitions"] and rng.random() < 0.2
    if rng.random() < 0.2:
        chosen_settings["rate_limit"] = rng.choice([0.0, 10.0, 50.0])
    if rng.random() < 0.1:
        chosen_settings["smoothing"] = "one_euro"
    if rng.random() < 0.1:
        chosen_settings["center"] = "centroid"
    preset = rng.choice(["default", "default", "game", "paper"])
    changes = {
        rng.randrange(len(times)): (name, rng.choice(values))
        for name, values in rng.choices(CHANGES, k=rng.choice([0, 0, 1, 4]))
    }
    settings = Settings.build(preset, chosen_settings)
    moves = rng.choice([None, 1, 3])
    follows = moves is not None and rng.random() < 0.5
    return Take(take.skeleton, positions, times, settings, moves, follows, changes)


def _spoilt(
    positions: NDArray[Any], fps: int, rng: random.Random, noise: np.random.Generator
) -> NDArray[Any]:
    """Return positions with the errors of sensors."""
    count, joints = positions.shape[:2]
    if rng.random() < 0.3:
        positions = positions + noise.normal(0, rng.choice([1e-4, 2e-3, 1e-2]), positions.shape)
    for _ in range(rng.choice([0, 0, 2, 8])):
        begin = rng.randrange(count)
        positions[
            begin : begin + rng.randint(1, 3 * fps), rng.sample(range(joints), rng.randint(1, joints))
        ] = np.nan
    for _ in range(rng.choice([0, 0, 0, 8])):
        positions[rng.randrange(count), rng.randrange(joints)] = rng.choice(
            [np.inf, 1e38, -1e300, 2e6, 5e-324]
        )
    if rng.random() < 0.1:
        begin = rng.randrange(count)
        positions[begin : begin + rng.randint(1, 40)] = 0.0
    if rng.random() < 0.15:
        positions = positions + noise.normal(0, rng.choice([20, 1e3, 9e4]), 3)
    return positions


def _spoilt_times(
    times: NDArray[np.float64], fps: int, rng: random.Random, noise: np.random.Generator
) -> NDArray[np.float64]:
    """Return times with the errors of clocks."""
    count = len(times)
    if rng.random() < 0.2:
        times = times + noise.normal(0, 0.3 / fps, count)
    for _ in range(rng.choice([0, 0, 1, 4])):
        times[rng.randrange(count) :] += rng.uniform(-5.0, 4.0)
    if rng.random() < 0.1:
        times[rng.randrange(count)] = rng.choice([np.nan, np.inf, -np.inf])
    return times + rng.choice([0.0, 0.0, 1e3, 1.7e9, -500.0])


def cuts(take: Take, size: int, rng: random.Random) -> Iterator[tuple[int, int]]:
    """Yield pieces of a take: of a size, or random ones for 0; changes lie between two of them."""
    count = len(take.times)
    places = {0, count, *take.changes}
    if size:
        places |= set(range(0, count, size))
    else:
        sizes = (rng.choice([1, 1, 2, 3, 7, 16, 64, 200]) for _ in itertools.count())
        places |= set(itertools.takewhile(lambda place: place < count, itertools.accumulate(sizes)))
    yield from itertools.pairwise(sorted(places))


def _told(work: Callable[[], list[Event] | None]) -> list[bytes]:
    """Return events as JSON; an error as its text."""
    try:
        return [to_json(event) for event in work() or []]
    except (SettingsError, FrameError) as error:
        return [f"refused: {error}".encode()]


def _changed(one: Segmenter, change: tuple[str, object]) -> list[bytes]:
    name, value = change
    if name == "moves":
        one.moves = None if value is None else moves_of(int(str(value)))
        return []
    if name == "poses":
        if one.moves is not None:
            one.moves = moves_of(len(one.moves.names), poses=bool(value))
        return []
    if name == "follow":
        one.follow = bool(value) and one.moves is not None
        return []
    if name in ("reset", "end"):
        return _told(one.reset if name == "reset" else one.end_take)
    return _told(lambda: one.change(**{name: value}))


def alone(take: Take, size: int, seed: int, snapshots: float = 0.0) -> list[bytes]:
    """Return the events of a take, cut into pieces of a size, with snapshots in between with some probability."""
    rng = random.Random(seed)  # noqa: S311 - no secret
    moves = None if take.moves is None else moves_of(take.moves)
    one, found = Segmenter(take.skeleton, take.settings, moves=moves, follow=take.follows), []
    for begin, end in cuts(take, size, rng):
        if begin in take.changes:
            found += _changed(one, take.changes[begin])
        if rng.random() < snapshots:
            one = Segmenter.restore(one.snapshot())
        single = end - begin == 1 and size == 1
        place: int | slice = begin if single else slice(begin, end)
        found += _told(lambda one=one, place=place: one.push(take.positions[place], take.times[place]))  # type: ignore[misc]
    return found + _told(lambda: one.end_take("over"))


def pooled(take: Take, size: int, seed: int) -> list[bytes]:
    """Return the events of a take in a pool beside another performer; changes of moves and settings are the pool's."""
    rng = random.Random(seed)  # noqa: S311 - no secret
    moves = None if take.moves is None else moves_of(take.moves)
    pool, found = Performers(take.settings, moves=moves, follow=take.follows), []
    for name in ("p1", "q"):
        pool.announce(name, take.skeleton)
    for begin, end in cuts(take, size, rng):
        if begin in take.changes:
            found += _changed(pool["p1"], take.changes[begin])
            _changed(pool["q"], take.changes[begin])
        frames, times = take.positions[begin:end], take.times[begin:end]
        if rng.random() < 0.5:
            found += _told(lambda f=frames, t=times: pool.push_many(["q", "p1"], np.stack([f, f]), t))  # type: ignore[misc]
        else:
            found += _told(lambda f=frames, t=times: pool.push(Frames(f, t, performer="p1")))  # type: ignore[misc]
            pool.push(Frames(frames, times, performer="q"))
    found += _told(lambda: pool["p1"].end_take("over"))
    return [line for line in found if b'"performer":"q"' not in line]


def recorded(take: Take, *, singly: bool) -> list[str]:
    """Return the results of a take as a recording, processed in one chunk or frame by frame."""
    moves = None if take.moves is None else moves_of(take.moves)
    try:
        result = segment_recording(
            take.positions, None, take.skeleton, take.settings, times=take.times, curves=singly, moves=moves,
            follow=take.follows,
        )  # fmt: skip
    except (SettingsError, FrameError) as error:
        return [f"refused: {error}"]
    tables = (
        result.key_frames,
        result.segments,
        result.moves,
        result.followed,
        result.poses,
        result.repetitions,
        result.steps,
    )
    limbs = [f"{name}: {own.key_frames} {own.repetitions}" for name, own in result.limbs.items()]
    return [*map(repr, tables), *limbs]


def lives(events: list[bytes]) -> list[str]:
    """Return deviations of events from docs/events.md: takes, revisions, last messages."""
    wrong, rev, final, takes = [], dict[tuple[str, str], int](), set[tuple[str, str]](), set[int]()
    take: int | None = None
    for line in events:
        if line.startswith(b"refused"):
            continue
        event = json.loads(line)
        kind = event["type"]
        if kind == "stream":
            if event["event"] == "started":
                wrong += [f"take twice: {line!r}"] if event["take"] in takes or take is not None else []
                take = event["take"]
                takes.add(event["take"])
            elif event["event"] == "ended":
                wrong += [f"ended, but not open: {line!r}"] if event["take"] != take else []
                take = None
            continue
        if event["take"] != take:
            wrong.append(f"outside its take: {line!r}")
        if "rev" not in event:
            continue
        key = kind, event["id"]
        if event["rev"] != rev.get(key, 0) + 1:
            wrong.append(f"revision {event['rev']} after {rev.get(key, 0)}: {line!r}")
        if key in final:
            wrong.append(f"after the last word: {line!r}")
        rev[key] = event["rev"]
        if event.get("decided") or event.get("status") in LAST_WORDS.get(kind, ()):
            final.add(key)
        if kind == "segment" and event["start_time"] > event["end_time"]:
            wrong.append(f"ends before it begins: {line!r}")
    return wrong + holes(events)


def holes(events: list[bytes]) -> list[str]:
    """Return gaps between the final segments of a take, of body and limbs each."""
    wrong, own = [], defaultdict[tuple[int, str], list[tuple[int, int, str]]](list)
    for line in events:
        if line.startswith(b'{"type":"segment"') and b'"status":"final"' in line:
            event = json.loads(line)
            place = event["start_frame"], event["end_frame"], event["id"]
            own[event["take"], event.get("channel", BODY)].append(place)
    for segments in own.values():
        for one, other in itertools.pairwise(sorted(segments)):
            if one[1] != other[0]:
                wrong.append(f"between {one[2]} and {other[2]} there is a hole, or they overlap")
    return wrong


def crowd_pooled(
    found: list[list[tuple[str, NDArray[Any]]]], times: NDArray[np.float64], take: Take, size: int, seed: int
) -> dict[str, list[bytes]]:
    """Return the events of each slot of a crowd in a pool, whose frames come in pieces of a size, with snapshots in between.

    Args:
        found: The poses of each moment, with their slots.
        times: s, of the moments.
        take: Whose skeleton, settings and moves they have.
        size: Moments of a piece; the frames of a slot without one in between come as one chunk.
        seed: Of snapshots.
    """
    rng, moves = random.Random(seed), None if take.moves is None else moves_of(take.moves)  # noqa: S311 - no secret
    pool, events = (
        Performers(take.settings, moves=moves, follow=take.follows),
        defaultdict[str, list[bytes]](list),
    )

    def note(more: list[Event]) -> None:
        for event in more:
            events[event.performer].append(to_json(event))

    for begin in range(0, len(times), size):
        pieces = defaultdict[str, list[int]](list)
        for i in range(begin, min(begin + size, len(times))):
            for slot, _ in found[i]:
                pieces[slot].append(i)
        for slot, own in pieces.items():
            if slot not in pool:
                note(pool.announce(slot, take.skeleton))
            poses = np.stack([dict(found[i])[slot] for i in own])
            note(pool.push(Frames(poses, times[own], performer=slot)))
        if size > 1 and rng.random() < 0.3:
            blobs, lasting = pool.snapshot(), pool.lasting()
            pool = Performers(take.settings, moves=moves, follow=take.follows)
            pool.restore(blobs, lasting)
    note(pool.end_takes("over"))
    return events


def check_crowd(seed: int, seconds: float) -> list[str]:
    """Return the faults of a crowd in slots, and of the events of its pool."""
    rng, noise = random.Random(-seed), np.random.default_rng(seed)  # noqa: S311 - no secret
    take = random_take(seed, seconds)
    fps, count = rng.choice([15, 30, 60]), rng.randint(2, 4)
    people = [
        performance(10 * seed + k, fps=float(fps), seconds=seconds, moves=rng.choice(MOVES[1:])).frames
        for k in range(count)
    ]
    least = min(len(one) for one in people)
    own = [np.array(one.positions[:least], np.float64) for one in people]
    poses = np.stack([_spoilt(one, fps, rng, noise) for one in own])
    times = np.array(people[0].times[:least]) + rng.choice([0.0, 1e3, 1.7e9])
    crowd = random_crowd(poses, times, rng)
    found, wrong = in_slots(crowd, rng)
    ways = {size: crowd_pooled(found, times, take, size, seed) for size in (1, 7, 64)}
    for size, events in ways.items():
        if events != ways[1]:
            wrong.append(f"a crowd: events in pieces of {size} moments are others")
    return wrong + [f"in slot {slot}: {line}" for slot, own in ways[1].items() for line in lives(own)]


def check(seed: int, seconds: float) -> tuple[Counter[str], list[str]]:
    """Return the number of events of each type in a take, and the faults."""
    take = random_take(seed, seconds)
    expected = alone(take, 64, seed)
    ways: dict[str, Callable[[], list[bytes]]] = {
        "single frames": lambda: alone(take, 1, seed),
        "chunks of 7": lambda: alone(take, 7, seed),
        "chunks of 1000": lambda: alone(take, 1000, seed),
        "random chunks, snapshots": lambda: alone(take, 0, seed, snapshots=0.2),
        "snapshots everywhere": lambda: alone(take, 64, seed, snapshots=1.0),
        "a pool": lambda: pooled(take, 32, seed),
    }
    wrong = lives(expected)
    whole, singly = recorded(take, singly=False), recorded(take, singly=True)
    if whole != singly:
        chunk, frames = next(pair for pair in zip(whole, singly, strict=True) if pair[0] != pair[1])
        wrong.append(f"as a recording: {chunk[:300]}, frame by frame {frames[:300]}")
    for name, way in ways.items():
        found = way()
        if found != expected:
            pairs = itertools.zip_longest(expected, found)
            place, (one, other) = next((k, pair) for k, pair in enumerate(pairs) if pair[0] != pair[1])
            wrong.append(f"{name}: event {place} is {other!r}, not {one!r}")
    types = (json.loads(line)["type"] for line in expected if not line.startswith(b"refused"))
    return Counter(types), wrong


def main() -> int:
    """Check takes, and print faults."""
    parser = argparse.ArgumentParser(prog="python -m checks.random_takes", description=__doc__.split("\n")[0])
    parser.add_argument("--takes", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1, help="of the first take")
    parser.add_argument("--seconds", type=float, default=6.0, help="length of a take at most")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    begun, events, bad, crowds = time.perf_counter(), Counter[str](), 0, 0
    for seed in range(options.seed, options.seed + options.takes):
        try:
            count, wrong = check(seed, options.seconds)
            if seed % CROWDED == 0:
                wrong += check_crowd(seed, min(options.seconds, LONGEST_CROWD))
                crowds += 1
        except (MovesError, ValueError, ArithmeticError, LookupError, TypeError) as error:
            count, wrong = Counter(), [f"{type(error).__name__}: {error}"]
        events += count
        bad += bool(wrong)
        if wrong and bad <= SHOWN:
            print(f"take {seed}:", *(line[:600] for line in wrong[:3]), sep="\n  ")
    seconds = time.perf_counter() - begun
    print(
        f"{options.takes} takes, 7 ways and 2 as a recording each, and {crowds} crowds: {bad} differ ({seconds:.0f} s)"
    )
    print("events:", ", ".join(f"{count} {kind}" for kind, count in events.most_common()))
    missing = {*TYPES} - {*events}
    if missing and options.takes >= ENOUGH:
        print("no take has events of the type", ", ".join(sorted(missing)))
        return 1
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
