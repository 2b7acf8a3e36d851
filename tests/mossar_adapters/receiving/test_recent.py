"""One rule for all who come by name: a newcomer replaces the one that has been silent longest, or is refused."""

import pytest

from mossar_adapters.receiving.recent import SILENT, Recent
from mossar_stream import FrameError


def full():
    kept = Recent(2, "performers")
    kept.add("ann", 1, 0.0)
    kept.add("bo", 2, 0.5)
    return kept


def test_there_is_room_until_all_places_are_taken():
    kept = Recent(2, "performers")
    assert kept.make_room("ann", 0.0) is None
    kept.add("ann", 1, 0.0)
    assert kept.make_room("bo", 0.0) is None
    assert (kept.hear("ann", 1.0), kept.get("ann"), kept.hear("bo", 1.0)) == (1, 1, None)


def test_the_one_that_has_been_silent_longest_makes_room():
    kept = full()
    kept.hear("ann", 1.0)
    assert kept.make_room("cy", 0.5 + SILENT) == ("bo", 2)
    assert list(kept.items()) == [("ann", 1)]


def test_while_all_are_heard_a_newcomer_is_refused_and_nothing_is_forgotten():
    kept = full()
    with pytest.raises(FrameError, match="2 performers are known and all of them move; cy is refused"):
        kept.make_room("cy", SILENT - 0.01)
    assert list(kept.values()) == [1, 2]
    assert len(kept) == 2
