import pytest

from mossar_adapters.receiving.owners import A_SECOND, AT_ONCE, Owners
from mossar_stream import FrameError


def test_a_second_connection_is_the_next_performer_and_stays_so():
    owners = Owners()
    for now in (0.0, 0.5, 1.0):
        assert [owners.name(connection, "p1", now) for connection in "abc"] == ["p1", "p2", "p3"]
    assert owners.forget("a") == ["p1"]
    assert owners.name("b", "p1", 1.1) == "p2", "a take goes on under its name"
    assert owners.name("d", "p1", 1.2) == "p1"


def test_names_that_are_no_numbers_get_one():
    owners = Owners()
    assert [owners.name(connection, "ann", 0.0) for connection in "abc"] == ["ann", "ann_2", "ann_3"]
    assert len({owners.name(connection, "x" * 200, 0.0) for connection in "abc"}) == 3


def test_the_next_number_is_one_that_nobody_has():
    owners = Owners()
    owners.name("a", "p1", 0.0)
    owners.name("a", "p2", 0.0)
    assert owners.name("b", "p1", 0.0) == "p3"


def test_the_name_of_a_silent_connection_passes_on(caplog):
    owners = Owners()
    owners.name("a", "p1", 0.0)
    assert owners.name("b", "p1", 2.0) == "p1"
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert owners.name("a", "p1", 2.1) == "p2", "the former owner is a newcomer"
    assert owners.forget("a") == ["p2"], "it takes nothing along that is another's"
    assert owners.forget("b") == ["p1"]


def test_a_connection_cannot_invent_names_without_end():
    owners = Owners()
    for k in range(AT_ONCE):
        owners.name("a", f"x{k}", 0.0)
    with pytest.raises(FrameError, match="names at once"):
        owners.name("a", "one more", 0.0)
    assert owners.name("a", "x3", 0.0) == "x3", "known ones go on"
    assert owners.name("b", "good", 0.0) == "good"
    for k in range(int(A_SECOND)):
        owners.name("a", f"y{k}", 1.0)
    with pytest.raises(FrameError):
        owners.name("a", "one more", 1.0)


def test_memory_does_not_grow_with_names():
    owners = Owners()
    for k in range(2000):
        owners.name("a", f"x{k}", float(k))
    assert len(owners.forget("a")) <= 256
