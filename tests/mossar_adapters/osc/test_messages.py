"""Messages as they come from anybody."""

import tracemalloc

from mossar_adapters.osc.messages import messages


def test_runs_of_numbers_are_read_in_order():
    head = b"/a\0\0,iffdhsfb\0\0\0"
    numbers = b"\0\0\0\1" + b"\x3f\x80\0\0" * 2 + b"\x40" + bytes(7) + bytes(7) + b"\5"
    ((address, arguments),) = messages(head + numbers + b"x\0\0\0" + b"\x3f\x80\0\0" + b"\0\0\0\1y\0\0\0")
    assert (address, list(arguments)) == ("/a", [1, 1.0, 1.0, 2.0, 5, "x", 1.0, b"y"])


def test_what_is_remembered_of_messages_of_strangers_is_small():
    tracemalloc.start()
    try:
        for number in range(4096):
            ((_, arguments),) = messages(b"/%010d\0," % number + b"f" * 490 + b"\0" + bytes(4 * 490))
            assert len(arguments) == 490
        assert tracemalloc.get_traced_memory()[0] < 8 << 20
    finally:
        tracemalloc.stop()
