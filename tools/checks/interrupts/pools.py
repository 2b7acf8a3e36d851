"""A pool of performers, and its state after exceptions: no events are lost, repeated, or given to another performer."""

import random
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from checks.interrupts.alone import CHANGES, FOLLOWING, Stage, Tally, as_json, differences, stage_of
from checks.interrupts.striking import Striking
from checks.random_takes import lives, moves_of
from mossar_stream import Event, FrameError, Frames, MovesError, Performers, Settings, SettingsError, Skeleton

FIRST = ("ann", "bob", "eve")
MOST = 3  # performers at a time
ROUNDS = 12  # exceptions in the life of a pool
APART = 170  # frames between the actions of performers
REFUSED = (SettingsError, FrameError, MovesError)
ALL: tuple[tuple[str, object], ...] = (*CHANGES, ("phase", True), ("phase", False))  # some are refused


class Blow(NamedTuple):
    """A call that an exception interrupts."""

    name: str
    value: object
    who: str | None  # one performer, or all
    frames: slice  # that are pushed, if it is a push


class Saved(NamedTuple):
    """Saved state of a pool that ends."""

    settings: Settings
    moves: int | None
    follow: tuple[str, ...] | bool
    blobs: Mapping[str, bytes]
    lasting: bytes


class Scene:
    """A pool, with the actions of its performers.

    Args:
        stage: The pushed frames, and the initial settings.
        saved: State to continue from; None to begin with the first performers.
    """

    def __init__(self, stage: Stage, saved: Saved | None = None) -> None:
        self.stage = stage
        self.moves = stage.moves if saved is None else saved.moves
        taught = None if self.moves is None else moves_of(self.moves)
        follow = stage.follow if saved is None else saved.follow
        self.pool = Performers(stage.settings, MOST, moves=taught, follow=follow)
        if saved is not None:
            self.pool.restore(saved.blobs, saved.lasting)
        else:
            for name in FIRST:
                self.pool.announce(name, stage.skeleton)

    def saved(self) -> Saved:
        """Return the state from which another pool continues."""
        blobs, lasting = self.pool.snapshot(), self.pool.lasting()
        count = None if self.pool.moves is None else len(self.pool.moves.names)
        return Saved(self.stage.settings, count, self.pool.follow, blobs, lasting)

    def do(self, blow: Blow) -> list[Event]:
        """Carry out the call of a blow; a refused one changes nothing."""
        try:
            return self._do(blow)
        except REFUSED:
            return []

    def _do(self, blow: Blow) -> list[Event]:
        pool, who = self.pool, blow.who
        name = str(who)
        match blow.name:
            case "push" if name in pool:
                return pool.push(self._frames(name, blow.frames))
            case "push_many":
                return self._push_together(next(iter(self._alike()), []), blow.frames)
            case "end_takes":
                return pool.end_takes()
            case "reset":
                return pool.reset(who)
            case "snapshot":
                self.saved()
            case "change":
                change: tuple[str, object] = blow.value  # type: ignore[assignment]
                return pool.change(who, **{change[0]: change[1]})
            case "level":
                pool.level = blow.value  # type: ignore[assignment]
            case "moves":
                pool.follow = pool.follow if blow.value else False
                pool.moves = None if blow.value is None else moves_of(int(str(blow.value)))
            case "follow":
                pool.follow = bool(blow.value) and pool.moves is not None
            case "announce":
                return pool.announce(name, _skeleton(self.stage.skeleton, int(str(blow.value))))
            case "remove" if name in pool:
                return pool.remove(name)
        return []

    def push_all(self, place: slice) -> list[Event]:
        """Push frames of all performers, of those with as many joints at once."""
        return [event for names in self._alike() for event in self._push_together(names, place)]

    def _alike(self) -> list[list[str]]:
        """Return the performers, those with as many joints together."""
        alike = defaultdict[int, list[str]](list)
        for name in self.pool.names:
            alike[self.pool[name].joints].append(name)
        return list(alike.values())

    def _push_together(self, names: list[str], place: slice) -> list[Event]:
        if not names:
            return []
        frames = [self._frames(name, place) for name in names]
        return self.pool.push_many(names, np.stack([own.positions for own in frames]), frames[0].times)

    def _frames(self, name: str, place: slice) -> Frames:
        joints = self.pool[name].joints
        return Frames(_positions(self.stage, name)[place, :joints], self.stage.times[place], performer=name)


def _skeleton(whole: Skeleton, joints: int) -> Skeleton:
    """Return the first joints of a skeleton."""
    return Skeleton(whole.names[:joints], whole.parents[:joints])


def _positions(stage: Stage, name: str) -> NDArray[np.float32]:
    """Return the motion of a performer: that of the others, at another time."""
    return np.roll(stage.positions, APART * (sum(map(ord, name)) % 7), axis=0)


WAYS: dict[str, Callable[[random.Random], object]] = {
    "push": lambda _: None,
    "push_many": lambda _: None,
    "end_takes": lambda _: None,
    "reset": lambda _: None,
    "snapshot": lambda _: None,
    "change": lambda rng: rng.choice(ALL),
    "level": lambda rng: rng.choice([0.1, 0.5, "motion", "posture"]),
    "moves": lambda rng: rng.choice([None, 1, 3]),
    "follow": lambda rng: rng.choice([True, False]),
    "announce": lambda rng: rng.choice([99, 99, -1]),
    "remove": lambda _: None,
}
OFTEN = ("push", "push_many", "push_many", "push_many", "announce", "end_takes", "reset", "change")


def _blows(rng: random.Random, scene: Callable[[], Scene]) -> Iterator[Blow]:
    """Yield the calls; in between `FOLLOWING` frames are pushed."""
    stage, begin, removed = scene().stage, rng.randint(30, 200), set[str]()
    yield Blow("push_many", None, None, slice(0, begin))
    for number in range(ROUNDS):
        names = scene().pool.names
        way = rng.choice([*WAYS, *OFTEN, "gap"])
        if way == "gap":
            stage.times[begin:] += rng.choice([-3.0, 3.0])
            way = "push_many"
        who: str | None = rng.choice(names) if names else None
        if way in ("reset", "change") and rng.random() < 0.6:
            who = None
        if way == "announce" and rng.random() < 0.7:
            others = [*FIRST, *(f"new{k}" for k in range(number + 1))]
            who = rng.choice([name for name in others if name not in removed and name not in names])
        if way == "remove" and who is not None:  # a performer that comes again would have the same ids
            removed.add(who)
        frames = rng.choice([1, 1, 7, 16]) if way in ("push", "push_many") else 0
        yield Blow(way, WAYS[way](rng), who, slice(begin, begin + frames))
        begin += frames + FOLLOWING
        if begin + 100 > len(stage.times):
            return


def _following(scene: Scene, blow: Blow) -> list[Event]:
    """Act like a program after an exception: announce or remove again, and push on."""
    events = scene.do(blow) if blow.name in ("announce", "remove") else []
    end = blow.frames.stop
    return events + scene.push_all(slice(end, end + FOLLOWING))


def _last_words(scene: Scene) -> list[Event]:
    """Return the events of a pool if all takes ended now, without changing it."""
    return Scene(scene.stage, scene.saved()).pool.end_takes()


def _expected(saved: Saved, stage: Stage, blow: Blow) -> Iterator[dict[str, list[bytes]]]:
    """Yield the permitted events, by performer: with the blow, without it, and with the first of its frames."""
    begin, end = blow.frames.start, blow.frames.stop
    for count in range(end - begin, -1, -1) if blow.name.startswith("push") else (1, 0):
        scene, events = Scene(stage, saved), []
        if count:
            frames = slice(begin, begin + count) if blow.name.startswith("push") else blow.frames
            events = scene.do(blow._replace(frames=frames))
        events += _following(scene, blow)
        yield _by_performer(events + _last_words(scene))


def _by_performer(events: list[Event]) -> dict[str, list[bytes]]:
    own = defaultdict[str, list[bytes]](list)
    for event in events:
        own[event.performer] += as_json([event])
    return own


def live_in_pool(seed: int, tally: Tally, compared: float) -> None:
    """Run a pool through some exceptions.

    Args:
        seed: Of the pool.
        tally: Findings are added to it.
        compared: Share of the exceptions after which the events are compared with those of other runs.
    """
    rng = random.Random(seed)  # noqa: S311 - no secret
    scene = Scene(stage_of(rng))
    blows = _blows(rng, lambda: scene)
    history = scene.do(next(blows))
    for blow in blows:
        saved = scene.saved() if rng.random() < compared else None
        strike = Striking(rng.choice([rng.randint(1, 10), rng.randint(1, 150), rng.randint(1, 2000)]))
        events: list[Event] = []
        with strike:
            events = scene.do(blow)
        tally.struck[f"pool {blow.name}"] += strike.has_struck
        if rng.random() < 0.15:
            scene = Scene(scene.stage, scene.saved())
        events += _following(scene, blow)
        history += events
        if saved is not None:
            tally.compared[f"pool {blow.name}"] += strike.has_struck
            found = _by_performer(events + _last_words(scene))
            expected = list(_expected(saved, scene.stage, blow))
            only_body = strike.has_struck and blow.name.startswith("push")
            for name in {*found, *expected[0]}:
                runs = iter([run.get(name, []) for run in expected])
                odd = differences(found.get(name, []), runs, only_body=only_body)
                told = f"pool {seed}, {blow}, struck {strike.has_struck}, {name}"
                tally.wrong.extend(f"{told}: {line}" for line in odd)
    history += scene.pool.end_takes()
    for name, lines in _by_performer(history).items():
        tally.wrong.extend(f"pool {seed}, {name}: {line}" for line in lives(lines))
