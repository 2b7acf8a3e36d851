"""The programs that measure and compare must themselves keep working."""

import re

import pytest

from mossar_tools.load import delay, load
from mossar_tools.wires import WIRES, Trial, compared


@pytest.mark.parametrize("transport", ["osc", "zmq"])
def test_a_light_load_arrives_whole(transport):
    said = load(transport, 60, 120.0, 4)
    assert re.search(r"60 frames of 4 joints sent in .* 60 segmented; nothing lost", said), said


def test_delays_are_those_of_every_message():
    said = delay("zmq", 4.0)
    assert re.match(r"zmq: 240 frames at 60 per second, \d+ key-frame messages; from sending", said), said


def test_a_wire_is_compared_with_the_recording():
    direct, found = compared("demo:?seconds=3", Trial(WIRES[0], 8.0, None))
    assert direct == found != []
