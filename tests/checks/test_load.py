"""The programs that measure and compare must themselves keep working."""

import re

import numpy as np
import pytest

from checks.delay import delays, in_words
from checks.load import load
from checks.wires import WIRES, Trial, compared


@pytest.mark.parametrize("transport", ["osc", "zmq"])
def test_a_light_load_arrives_whole(transport):
    said = load(transport, 60, 120.0, 4)
    assert re.search(r"60 frames of 4 joints sent in .* 60 segmented; nothing lost", said), said


def test_delays_are_those_of_every_message():
    found = delays("zmq", 4.0)
    assert found.frames == len(found.echoed) == 240
    assert len(found.through) > 2
    assert 0 < min(found.echoed) < np.median(found.through) < 1.0
    said = in_words("zmq", found)
    assert said.startswith(f"zmq: 240 frames at 60 per second, {len(found.through)} key-frame messages"), said
    assert re.search(r"added +median -?\d+\.\d\d ms, 99 % ", said), said


def test_a_wire_is_compared_with_the_recording():
    direct, found = compared("demo:?seconds=3", Trial(WIRES[0], 8.0, None))
    assert direct == found != []
