from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.demo.body import SKELETON
from mossar_adapters.people import PeopleSource
from mossar_adapters.source import Departure, Meta, Occupant
from mossar_stream import Frames

FPS = 60.0
APART = 1.5  # m


class Script:
    """A source that yields what it was given."""

    def __init__(self, items: Sequence[object], *, live: bool = True) -> None:
        self.name, self.live = "script", live
        self._items = items

    def items(self) -> Iterator[object]:
        yield from self._items

    def close(self) -> None:
        pass


@pytest.fixture(scope="session")
def bodies():
    """Motion of three people, (3, n, J, 3), side by side."""
    motions = []
    for seed in (1, 2, 3):
        source = DemoSource.from_url(f"demo:?seed={seed}&seconds=20", speed="max")
        found = np.concatenate([f.positions for f in source.items() if isinstance(f, Frames)])
        motions.append(found * (0.92, 1.0, 1.1)[seed - 1] + np.float32([APART * seed, 0, 3]))
    return np.stack([motion[: min(map(len, motions))] for motion in motions]).astype(np.float32)


@pytest.fixture
def tracked(bodies):
    """Return a function: items of a tracker that gives person k in frame i the id `ids(k, i)`, None for none."""

    def items(ids, frames=600, people=2, chunk=1, positions=None):
        shown = bodies if positions is None else positions
        names = sorted({n for k in range(people) for i in range(frames) if (n := ids(k, i))})
        found = [Meta(name, SKELETON) for name in names]
        for start in range(0, frames, chunk):
            rows = {}
            for i in range(start, min(start + chunk, frames)):
                for k in range(people):
                    if ids(k, i):
                        rows.setdefault(ids(k, i), []).append((k, i))
            for name, where in rows.items():
                poses = np.stack([shown[k, i] for k, i in where])
                found.append(Frames(poses, np.array([i / FPS for _, i in where]), performer=name))
        return found

    return items


@pytest.fixture
def played(bodies):
    """Return a function: plays items through slots; returns the slot of each person in each frame, and the rest."""

    def play(items, people=2, frames=600, positions=None, **options):
        shown = bodies if positions is None else positions
        owners = {(i, shown[k, i].tobytes()): k for k in range(len(shown)) for i in range(frames)}
        slots = np.zeros((len(shown), frames), int)
        others = []
        for item in PeopleSource(Script(items), people, **options).items():
            if isinstance(item, Frames):
                for pose, time in zip(item.positions, item.times, strict=True):
                    i = round(time * FPS)
                    assert not (slots[:, i] == int(item.performer[1:])).any(), "two people in one slot"
                    slots[owners[i, pose.tobytes()], i] = int(item.performer[1:])
            elif isinstance(item, Occupant | Departure):
                others.append(item)
        return slots, others

    return play


@pytest.fixture
def script():
    """Return the source that yields what it is given."""
    return Script
