"""Memory: the people of slots as bytes, for a run that goes on after it was cut short.

Ids, pins, the lengths of bones and the places where people were seen last are kept. Undecided newcomers are
not: they are newcomers again.
"""

from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.people.body import Body
from mossar_adapters.people.given import MOST, People
from mossar_adapters.people.samples import SAMPLES, Samples
from mossar_stream import MossarError, Skeleton, SnapshotError

_IDS: Final = 256  # former owners of ids, as `Slots` keeps them


class Person(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The person in a slot.

    Args:
        number: Of the slot, from 0.
        id: The sender's.
        met: How many people were met before this one, this one included.
        pinned: Whether the slot is kept for this person.
        time: When it was seen last, s.
        skeleton: None if it was not announced.
        joints: J.
        pose: (J, 3) float32, metres.
        samples: (n, J, 3) float32, metres.
    """

    number: int
    id: str | None
    met: int
    pinned: bool
    time: float
    skeleton: Skeleton | None
    joints: int
    pose: bytes
    samples: bytes


class Memory(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The people of all slots.

    Args:
        people: Number of slots, or for whom the only one is.
        now: Time of the latest frame, s.
        met: People so far.
        reuses: Whether an id went from one person to another.
        former: The person who had each id last: `Person.met`.
        chosen: Number of the person in the only slot.
        slots: Those that were used.
    """

    people: People
    now: float
    met: int
    reuses: bool
    former: dict[str, int]
    chosen: int | None
    slots: tuple[Person, ...]

    def to_bytes(self) -> bytes:
        """Return the memory as bytes."""
        return msgspec.msgpack.encode(self)

    @classmethod
    def from_bytes(cls, data: bytes) -> "Memory":
        """Return the memory in bytes, which may come from an unknown source.

        Raises:
            SnapshotError: If it is none.
        """
        try:
            found = _decoder.decode(data)
        except (msgspec.DecodeError, MossarError, RecursionError, UnicodeError) as error:
            raise SnapshotError(f"the people of the snapshot are damaged: {error}") from None
        numbers = [person.number for person in found.slots]
        if len(set(numbers)) < len(numbers) or len(found.former) > _IDS or not np.isfinite(found.now):
            raise SnapshotError(
                "the people of the snapshot are damaged: slots, ids or the time are impossible"
            )
        for person in found.slots:
            _check(person)
        return found


_decoder = msgspec.msgpack.Decoder(Memory)


def person_of(body: Body) -> Person:
    """Return the saved part of a body."""
    return Person(
        body.number,
        body.id,
        body.met,
        body.pinned,
        body.time,
        body.skeleton,
        len(body.pose),
        _packed(body.pose),
        _packed(body.samples.poses),
    )


def put_person(body: Body, person: Person) -> None:
    """Put a remembered person into a body that was never used."""
    body.id, body.met, body.pinned = person.id, person.met, person.pinned
    body.begin(_poses(person.pose, person.joints)[0], person.time, person.skeleton)
    body.samples = Samples.of(_poses(person.samples, person.joints), person.joints)


def persons_of(bodies: Sequence[Body]) -> tuple[Person, ...]:
    """Return the saved part of the bodies that were used."""
    return tuple(person_of(body) for body in bodies if body.used)


def _check(person: Person) -> None:
    """Refuse a person that cannot be.

    Raises:
        SnapshotError: If it cannot.
    """
    size = 12 * person.joints
    sound = (
        0 <= person.number < MOST
        and person.met > 0
        and np.isfinite(person.time)
        and person.joints > 0
        and (person.skeleton is None or len(person.skeleton) == person.joints)
        and len(person.pose) == size
        and len(person.samples) % size == 0
        and len(person.samples) <= SAMPLES * size
    )
    if not sound:
        raise SnapshotError(f"the people of the snapshot are damaged: slot {person.number + 1} is impossible")


def _packed(poses: NDArray[Any]) -> bytes:
    return poses.astype("<f4").tobytes()


def _poses(data: bytes, joints: int) -> NDArray[np.float32]:
    return np.frombuffer(data, "<f4").astype(np.float32).reshape(-1, joints, 3)
