"""The verdict on slots in a scene, played through the source that `--people` makes."""

import time
from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from checks.people.actors import FPS
from checks.people.scenes import Scene
from mossar_adapters.people import PeopleSource, Slots
from mossar_adapters.source import Item, Meta, Occupant
from mossar_stream import Frames


class SceneSource:
    """Plays a scene as a tracker would send it: implements `Source`.

    Args:
        scene: The scene to play.
        chunk: Frames of each id that come at once.
    """

    name, live = "scene", True

    def __init__(self, scene: Scene, chunk: int) -> None:
        self._scene = scene
        self._chunk = chunk

    def items(self) -> Iterator[Item]:
        """Yield the frames of each id, in chunks."""
        scene = self._scene
        times = scene.times
        announced: set[int] = set()
        for start in range(0, len(times), self._chunk):
            window = slice(start, start + self._chunk)
            for number in np.unique(scene.ids[:, window]):
                if not number:
                    continue
                if number not in announced:
                    announced.add(int(number))
                    yield Meta(f"p{number}", scene.skeleton)
                where = np.argwhere(number == scene.ids[:, window].T)  # (k, 2) frame and person
                at = where[:, 0] + start
                yield Frames(
                    scene.positions[where[:, 1], at].astype(np.float32), times[at], performer=f"p{number}"
                )

    def close(self) -> None:
        """Do nothing."""


class Verdict(msgspec.Struct):
    """Result of a scene.

    Args:
        frames: Of all people who were visible.
        right: Those in the slot in which the person was first.
        lost: Those in no slot.
        doubles: Moments with two people in one slot.
        silent: Frames whose slot went to another id without a message.
        returns: People who came back from a long absence.
        found: Those who got the slot of before.
        slots: (P, n) number of the slot of each person in each frame, 0 for none.
    """

    frames: int
    right: int
    lost: int
    doubles: int
    silent: int
    returns: int
    found: int
    slots: NDArray[np.intp]


def judge(scene: Scene, people: int | None = None, chunk: int = 1) -> Verdict:
    """Play a scene and return how it went.

    Args:
        scene: The scene to play.
        people: Slots; None for as many as people.
        chunk: Frames that come at once.
    """
    count, frames = scene.ids.shape
    owners = {
        (i, scene.positions[p, i].astype(np.float32).tobytes()): p
        for p in range(count)
        for i in range(frames)
        if scene.ids[p, i]
    }
    slots = np.zeros((count, frames), np.intp)
    doubles = silent = 0
    at_slot: dict[str, int] = {}  # the id that was announced last
    taken: set[tuple[str, int]] = set()
    for item in PeopleSource(SceneSource(scene, chunk), people or count).items():
        if isinstance(item, Occupant):
            at_slot[item.performer] = int(item.id[1:])
        if not isinstance(item, Frames):
            continue
        for pose, moment in zip(item.positions, item.times, strict=True):
            i = round(float(moment) * FPS)
            person = owners[i, pose.tobytes()]
            slots[person, i] = int(item.performer[1:])
            doubles += (item.performer, i) in taken
            taken.add((item.performer, i))
            silent += at_slot.get(item.performer) != scene.ids[person, i]
    visible = scene.ids > 0
    first = np.array([next((int(s) for s in row if s), -1) for row in slots])
    right = (slots == first[:, None]) & visible
    found = sum(slots[p, i] == first[p] for p, i in scene.returns)
    return Verdict(
        int(visible.sum()),
        int(right.sum()),
        int(((slots == 0) & visible).sum()),
        doubles,
        silent,
        len(scene.returns),
        int(found),
        slots,
    )


def cost(scene: Scene, chunk: int) -> float:
    """Return the cost of slots for a frame of a person, microseconds.

    Args:
        scene: The scene to play.
        chunk: Frames that come at once; 1 uses `Slots.follow`, as programs do.
    """
    items = [item for item in SceneSource(scene, chunk).items() if item is not None]
    slots = Slots(len(scene.ids))
    frames = [item for item in items if isinstance(item, Frames)]
    for item in items:
        if isinstance(item, Meta):
            slots.announce(item.performer, item.skeleton)
    count = sum(len(f) for f in frames)
    if chunk == 1:
        singles = [(f.performer, f.positions[0], float(f.times[0])) for f in frames]
        begin = time.process_time()
        for ident, pose, at in singles:
            slots.follow(ident, pose, at)
    else:
        source = PeopleSource(SceneSource(scene, chunk), len(scene.ids))
        begin = time.process_time()
        for item in items:
            source.take(item)  # without the cost of the scene itself
    return (time.process_time() - begin) / count * 1e6
