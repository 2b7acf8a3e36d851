"""Whose a datagram is, where that shows only with the next ones."""

import itertools

import pytest

from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.receiving.attribution import MOST_WAITING, Attribution
from mossar_adapters.receiving.senders import WAIT, Senders

HOST = "192.0.2.7"


def attribution():
    return Attribution(Senders())


def sent(port, arrival, host=HOST):
    return Datagram(b"", host, port, arrival)


def whose(found):
    """Return the port of each datagram and whether it is another sender's than the first."""
    return [(piece.port, bool(suffix)) for piece, suffix in found]


@pytest.mark.parametrize("programs", [2, 3, 6])
@pytest.mark.parametrize("pieces", [1, 3])
def test_programs_that_start_at_once_are_distinguished_from_the_first_datagram_on(programs, pieces):
    attributed = attribution()
    found = []
    for frame, port, piece in itertools.product(range(40), range(programs), range(pieces)):
        found += attributed.put(sent(port, frame / 30 + port * 1e-3 + piece * 1e-4))
    found += attributed.settle(9.0)
    assert len(found) == 40 * programs * pieces
    assert all(bool(suffix) == (piece.port != 0) for piece, suffix in found)
    assert len({suffix for _, suffix in found}) == programs
    for port in range(programs):
        arrivals = [piece.arrival for piece, _ in found if piece.port == port]
        assert arrivals == sorted(arrivals)


def test_a_new_port_waits_until_the_first_one_is_heard_again():
    attributed = attribution()
    assert whose(attributed.put(sent(1, 0.0))) == [(1, False)]
    assert whose(attributed.put(sent(2, 0.001))) == []
    assert attributed.pending
    assert whose(attributed.settle(0.01)) == []
    assert whose(attributed.put(sent(1, 0.033))) == [(2, True), (1, False)]
    assert not attributed.pending


def test_a_port_that_follows_a_silent_one_is_the_same_sender():
    attributed = attribution()
    for k in range(5):
        assert whose(attributed.put(sent(1, k / 30))) == [(1, False)]
    for k in range(4):  # the program was started again at once
        assert whose(attributed.put(sent(2, 4 / 30 + k / 1000))) == []
    assert whose(attributed.settle(4 / 30 + WAIT)) == [(2, False)] * 4
    assert whose(attributed.put(sent(2, 0.4))) == [(2, False)]


def test_one_that_started_again_and_another_one_are_distinguished_after_the_wait():
    attributed = attribution()
    found = attributed.put(sent(1, 0.0))
    for k in range(3):
        for port in (2, 3):
            found += attributed.put(sent(port, 0.01 + k / 100 + port / 1000))
    assert whose(found) == [(1, False)]
    assert whose(attributed.settle(0.0 + WAIT)) == [(2, False), (3, True)] * 2 + [(2, False), (3, True)]


def test_other_hosts_do_not_wait():
    attributed = attribution()
    assert len(attributed.put(sent(1, 0.0)) + attributed.put(sent(2, 0.001))) == 1
    assert whose(attributed.put(sent(5, 0.002, "192.0.2.8"))) == [(5, True)]


def test_a_port_for_every_message_waits_only_at_first():
    attributed = attribution()
    counts = [len(attributed.put(sent(port, port / 60))) for port in range(100)]
    assert sum(counts) == 100
    assert set(counts[10:]) == {1}


def test_what_waits_is_limited():
    attributed = attribution()
    found = attributed.put(sent(1, 0.0))
    for k in range(2 * MOST_WAITING):
        found += attributed.put(sent(2, 0.001 + k * 1e-5))
    assert len(found) > MOST_WAITING
    assert whose(found) == [(1, False)] + [(2, False)] * (len(found) - 1)
