"""Random takes and crowds agree with themselves; what they look for is found."""

import random

import numpy as np
import pytest

from checks import random_takes
from checks.random_crowds import HIDDEN, in_slots, random_crowd
from mossar_adapters.people import Slots


@pytest.fixture(autouse=True)
def quiet():
    with np.errstate(all="ignore"):
        yield


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("seed", [3, 6])
def test_a_take_and_a_crowd_agree(seed):
    found, wrong = random_takes.check(seed, 3.0)
    assert found
    assert wrong == []
    assert random_takes.check_crowd(seed, 2.0) == []


def crowd(seed):
    rng = random.Random(seed)
    body = np.random.default_rng(seed).normal(0, 0.3, (3, 1, 12, 3))
    return random_crowd(np.repeat(body, 60, axis=1), np.arange(60) / 30, rng), rng


def test_crowds_have_all_that_may_happen_to_ids():
    happened = set()
    for seed in range(30):
        people, _ = crowd(seed)
        own = list(zip(*people.ids, strict=True))
        happened |= {"hidden"} if any(HIDDEN in ids for ids in own) else set()
        happened |= {"new"} if any(len({*ids} - {HIDDEN}) > 1 for ids in own) else set()
        happened |= (
            {"exchanged"}
            if any({*one} & {*other} - {HIDDEN} for one in own for other in own if one != other)
            else set()
        )
        happened |= {"refused"} if people.slots < len(own) else set()
        in_one_moment = [[ident for ident in ids if ident != HIDDEN] for ids in people.ids]
        assert all(len(set(ids)) == len(ids) for ids in in_one_moment)
    assert happened == {"hidden", "new", "exchanged", "refused"}


def test_two_people_in_one_slot_are_found(monkeypatch):
    people, rng = crowd(1)
    assert in_slots(people, rng)[1] == []
    monkeypatch.setattr(Slots, "decide", lambda *of: ["p1"] * len(of[2]))
    assert "two people are in one slot" in in_slots(people, rng)[1][0]


def test_slots_that_a_snapshot_forgets_are_found(monkeypatch):
    people, rng = crowd(2)
    monkeypatch.setattr(Slots, "recall", lambda *_: None)
    assert "after a snapshot" in in_slots(people, rng)[1][0]


def test_a_message_after_the_last_word_is_found():
    line = b'{"type":"%s","id":"p1/x/0/1","rev":%d,"status":"%s","take":0}'
    begun = b'{"type":"stream","event":"started","take":0}'
    for kind, status in ((b"pose", b"left"), (b"follow", b"done"), (b"follow", b"left"), (b"move", b"final")):
        wrong = random_takes.lives([begun, line % (kind, 1, status), line % (kind, 2, status)])
        assert len(wrong) == 1
        assert "after the last word" in wrong[0]
