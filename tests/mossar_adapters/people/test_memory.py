"""People of a run that was cut short, in the next one."""

import logging

import msgspec
import numpy as np
import pytest

from mossar_adapters.demo.body import SKELETON
from mossar_adapters.people import PeopleSource, Slots
from mossar_adapters.people.memory import Memory
from mossar_adapters.source import Departure, Meta, Occupant
from mossar_stream import Frames, SnapshotError

FPS = 60.0


def seen(people=2, frames=120, bodies=None, ids="AB", begin=1000.0):
    """Return slots that have seen people for a while."""
    slots = Slots(people)
    for ident in ids:
        slots.announce(ident, SKELETON)
    for i in range(frames):
        slots.decide(begin + i / FPS, [(ident, bodies[k, i]) for k, ident in enumerate(ids)])
    return slots


def recalled(slots, people=2):
    fresh = Slots(people)
    fresh.recall(slots.to_bytes())
    return fresh


def test_people_keep_their_slots_whoever_comes_first(bodies):
    after = recalled(seen(bodies=bodies))
    after.restart(5.0, 20.0)  # another clock, 20 s later
    for ident in "BA":
        after.announce(ident, SKELETON)
    found = []
    for i in range(150):
        found = [after.follow(ident, bodies["AB".index(ident), i], 5.0 + i / FPS) for ident in "BA"]
    assert found == ["p2", "p1"]
    assert [row["id"] for row in after.table()] == ["A", "B"]


def test_an_id_that_went_to_another_slot_is_in_that_one_afterwards(bodies):
    slots = seen(bodies=bodies)
    for i in range(120, 125):  # the tracker gives the first person the id B, whose person has left
        assert slots.decide(1000 + i / FPS, [("B", bodies[0, i])]) == ["p1"]
    assert [row["id"] for row in slots.table()] == ["B", "B"]
    assert recalled(slots).slot_of("B") == slots.slot_of("B") == "p1"


def test_people_under_new_ids_are_known_by_their_bones(bodies):
    after = recalled(seen(bodies=bodies))
    after.restart(5.0, 20.0)
    for ident in "XY":
        after.announce(ident, SKELETON)
    for i in range(150):
        found = after.decide(5.0 + i / FPS, [("X", bodies[1, i]), ("Y", bodies[0, i])])
    assert found == ["p2", "p1"]


def test_pins_stay_and_a_pinned_slot_is_not_given_to_another(bodies):
    slots = seen(bodies=bodies, ids="A")
    slots.pin("p1")
    after = recalled(slots)
    after.restart(5.0, 5000.0)
    after.announce("Z", SKELETON)
    for i in range(150):
        found = after.follow("Z", bodies[2, i], 5.0 + i / FPS)
    assert found == "p2"
    assert [row["pinned"] for row in after.table()] == [True, False]


def test_a_memory_of_a_memory_is_the_same(bodies):
    slots = seen(bodies=bodies)
    assert recalled(slots).to_bytes() == slots.to_bytes()
    assert Slots(2).to_bytes() == recalled(Slots(2)).to_bytes()


@pytest.mark.parametrize("people", ["first", "nearest"])
def test_the_only_slot_stays_with_its_person(bodies, people):
    slots = seen(people, bodies=bodies)
    after = recalled(slots, people)
    assert after.table()[0]["id"] == slots.table()[0]["id"]
    with pytest.raises(SnapshotError, match=people):
        Slots(2).recall(slots.to_bytes())


def test_fewer_slots_than_before_leave_the_others_out(bodies):
    after = recalled(seen(bodies=bodies), 1)
    assert [row["id"] for row in after.table()] == ["A"]


WRONG = {
    "a slot twice": {"slots": 2},
    "a slot too far": {"number": 64},
    "too few bytes of a pose": {"pose": b"123"},
    "no joints": {"joints": 0},
    "another skeleton": {"joints": 2, "pose": bytes(24), "samples": b""},
    "no time": {"time": float("nan")},
    "too many samples": {"samples": bytes(12 * len(SKELETON) * 65)},
    "a negative number": {"number": -1},
}


@pytest.mark.parametrize("change", WRONG.values(), ids=WRONG)
def test_damaged_people_are_refused(bodies, change):
    memory = Memory.from_bytes(seen(bodies=bodies, ids="A").to_bytes())
    person = memory.slots[0]
    damaged = msgspec.structs.replace(person, **({} if "slots" in change else change))
    slots = (damaged,) * change.get("slots", 1)
    with pytest.raises(SnapshotError, match="damaged"):
        Memory.from_bytes(msgspec.structs.replace(memory, slots=slots).to_bytes())


@pytest.mark.parametrize("data", [b"", b"\x80", b"\xc1", bytes(100)])
def test_bytes_that_are_no_memory_are_refused(data):
    with pytest.raises(SnapshotError, match="damaged"):
        Memory.from_bytes(data)


def test_a_source_goes_on_with_its_people_on_another_clock(bodies, tracked, script, caplog):
    before = PeopleSource(script([]), 2)
    for item in tracked(lambda k, _i: "AB"[k], frames=120):
        before.take(item)
    after = PeopleSource(script([]), 2)
    with caplog.at_level(logging.INFO):
        after.recall(before.to_bytes())
    assert "p1 was id A, p2 was id B" in caplog.text
    found = [Meta(ident, SKELETON) for ident in "BA"]
    for i in range(200):
        found += [
            Frames(bodies["AB".index(n), i][None], np.array([9e5 + i / FPS]), performer=n) for n in "BA"
        ]
    items = [out for item in found for out in after.take(item)]
    items += [out for out in after.take(None) if out is not None]
    assert not any(item.another for item in items if isinstance(item, Occupant))
    last = [item for item in items if isinstance(item, Frames)][-2:]
    named = {item.performer: item.positions[-1].tobytes() for item in last}
    assert named == {"p1": bodies[0, 199].tobytes(), "p2": bodies[1, 199].tobytes()}
    assert not any(isinstance(item, Departure) for item in items)


@pytest.mark.parametrize("data", [b"", b"damaged"])
def test_what_was_learned_of_people_who_cannot_be_recalled_is_forgotten(bodies, script, data, caplog):
    source = PeopleSource(script([]), 2)
    source.recall(data)
    assert ("everybody is new" in caplog.text) == bool(data)
    source.take(Meta("A", SKELETON))
    items = []
    for i in range(200):
        items += source.take(Frames(bodies[0, i][None], np.array([i / FPS]), performer="A"))
    occupants = [item for item in items if isinstance(item, Occupant)]
    assert [item.another for item in occupants] == [True]
