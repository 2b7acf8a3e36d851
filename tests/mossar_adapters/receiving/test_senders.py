from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.receiving.attribution import Attribution
from mossar_adapters.receiving.senders import Senders

HOST = "192.0.2.7"


def names(senders, *datagrams):
    """Return whose each datagram is, of (port, s) each, in the order in which it is known."""
    attribution = Attribution(senders)
    found = [one for port, now in datagrams for one in attribution.put(Datagram(b"", HOST, port, now))]
    found += attribution.settle(datagrams[-1][1] + 1.0)
    return [senders.name(suffix) for _, suffix in found]


def test_a_second_program_is_told_apart_with_its_first_datagram():
    senders = Senders()
    assert set(names(senders, *((1, k / 60) for k in range(60)))) == {"p1"}
    assert names(senders, (2, 1.0), (1, 1.01), (3, 1.02), (2, 1.03), (1, 1.04)) == [
        "p2",
        "p1",
        "p3",
        "p2",
        "p1",
    ]


def test_a_program_that_starts_again_keeps_its_name():
    senders = Senders()
    names(senders, *((1, k / 60) for k in range(60)))
    assert set(names(senders, *((2, 3.0 + k / 60) for k in range(60)))) == {"p1"}


def test_a_socket_for_every_message_is_one_sender():
    assert set(names(Senders(), *((k, k / 60) for k in range(200)))) == {"p1"}


def test_another_computer_has_the_next_number():
    senders = Senders()
    found = [senders.name(senders.suffix(f"192.0.2.{k}", 5, 0.0)) for k in (1, 2, 3)]
    assert found == ["p1", "p2", "p3"]


def test_a_name_that_the_user_gave_is_told_apart_by_the_address():
    senders = Senders("ann")
    assert [senders.name(senders.suffix(f"192.0.2.{k}", 5, 0.0)) for k in (1, 2)] == ["ann", "ann_192_0_2_2"]
