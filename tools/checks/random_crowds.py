"""Random crowds: people whose ids are cut, exchanged, hidden and given anew, and the slots that they get."""

import random
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.people import Slots
from mossar_stream import Skeleton

APART = 0.9  # m between neighbours
HIDDEN = ""  # instead of an id


class Crowd(NamedTuple):
    """People side by side, as a tracker sees them.

    Args:
        positions: (P, n, J, 3) m.
        times: (n,) s.
        ids: Of each moment, the id of each person; `HIDDEN` if there is none.
        slots: Number of slots; fewer than people in some crowds.
    """

    positions: NDArray[np.float64]
    times: NDArray[np.float64]
    ids: list[list[str]]
    slots: int


def random_crowd(positions: NDArray[np.float64], times: NDArray[np.float64], rng: random.Random) -> Crowd:
    """Return people side by side, some of whom are hidden, get new ids, or exchange theirs.

    Args:
        positions: (P, n, J, 3) m, of people at one place.
        times: (n,) s.
        rng: Source of chance.
    """
    people, count = positions.shape[:2]
    aside = np.zeros((people, 1, 1, 3))
    aside[:, 0, 0, 0] = APART * np.arange(people)
    own, latest = [f"a{p}" for p in range(people)], people
    hidden_until = [0] * people
    happens = {
        rng.randrange(count): rng.choice(["cut", "hide", "swap", "all"]) for _ in range(rng.randint(0, 6))
    }
    ids = list[list[str]]()
    for i in range(count):
        what = happens.get(i)
        one, other = rng.randrange(people), rng.randrange(people)
        if what == "swap":
            own[one], own[other] = own[other], own[one]
        for p in range(people):
            if what == "all" or (p == one and what in ("cut", "hide")):
                own[p], latest = f"a{latest}", latest + 1
                hidden_until[p] = i if what == "cut" else i + rng.randint(1, count)
        ids.append([HIDDEN if i < hidden_until[p] else own[p] for p in range(people)])
    return Crowd(positions + aside, times, ids, rng.choice([people, people, max(1, people - 1), 64]))


def in_slots(crowd: Crowd, rng: random.Random) -> tuple[list[list[tuple[str, NDArray[Any]]]], list[str]]:
    """Return the poses of each moment with their slots, and the faults of the slots."""
    people, joints = crowd.positions.shape[0], crowd.positions.shape[2]
    skeleton = Skeleton(tuple(f"j{j}" for j in range(joints)), (-1, *range(joints - 1)))
    slots, announced = Slots(crowd.slots), set[str]()
    found, wrong = list[list[tuple[str, NDArray[Any]]]](), list[str]()
    for i, time in enumerate(crowd.times.tolist()):
        seen = [(crowd.ids[i][p], crowd.positions[p, i]) for p in range(people) if crowd.ids[i][p] != HIDDEN]
        for ident in {ident for ident, _ in seen} - announced:
            slots.announce(ident, skeleton)
            announced.add(ident)
        known = {ident: slots.slot_of(ident) for ident, _ in seen}
        if rng.random() < 0.05:
            wrong += _differences(slots, crowd.slots, known, i)
        given = slots.decide(time, seen)
        mine = [(slot, pose) for slot, (_, pose) in zip(given, seen, strict=True) if slot]
        names = [slot for slot, _ in mine]
        if len(set(names)) < len(names):
            wrong.append(f"moment {i}: two people are in one slot: {names}")
        if not set(names) <= set(slots.names):
            wrong.append(f"moment {i}: slots that there are not: {names}")
        found.append(mine)
    return found, wrong


def _differences(slots: Slots, count: int, known: dict[str, str | None], i: int) -> list[str]:
    """Return the known ids whose slots are others after a snapshot."""
    again = Slots(count)
    again.recall(slots.to_bytes())
    return [
        f"moment {i}: {ident} was {slot}, and is {again.slot_of(ident)} after a snapshot"
        for ident, slot in known.items()
        if slot and again.slot_of(ident) != slot
    ]
