"""Summaries that come from outside are worked on only if the core cannot hang on them."""

import numpy as np
import pytest

from mossar_stream.core.kernels import DURATION, pad
from mossar_stream.core.kernels import similarity_strength as strength
from mossar_stream.settings import Settings
from mossar_stream.similarity import protocol as similarity

MEASURES = [
    {"similarity": "likelihood"},
    {"similarity": "path_kernel", "location": "none"},
    {"similarity": "path_kernel", "location": "none", "kernel_form": "normalised", "layers": 3},
]
JOINTS = 5


def summaries(chosen, count=3):
    settings = Settings(**chosen).resolved()
    params = similarity.make_params(settings, JOINTS, pad(JOINTS), 0)
    return settings, params, np.zeros((count, similarity.slot_size(settings, params)))


@pytest.mark.parametrize("chosen", MEASURES, ids=str)
@pytest.mark.parametrize("duration", [np.nan, np.inf, -np.inf, -1.0, -1e-5])
def test_a_duration_that_is_no_time_is_refused(chosen, duration):
    settings, params, slots = summaries(chosen)
    assert similarity.are_sound(settings, params, slots)
    slots[1, DURATION] = duration
    assert not similarity.are_sound(settings, params, slots)


@pytest.mark.parametrize("chosen", MEASURES, ids=str)
def test_what_rounding_leaves_of_a_duration_is_accepted(chosen):
    settings, params, slots = summaries(chosen)
    slots[1, DURATION] = -1e-12
    assert similarity.are_sound(settings, params, slots)


@pytest.mark.parametrize("chosen", MEASURES, ids=str)
@pytest.mark.parametrize("duration", [np.nan, -1.0, 0.0])
def test_a_segment_that_lasts_no_time_says_nothing(chosen, duration):
    _, params, slots = summaries(chosen)
    slots[0, DURATION], slots[1, DURATION] = duration, 1.0
    assert strength(params, *slots) == 0.0
    slots[0, DURATION], slots[1, DURATION] = 1.0, duration
    assert strength(params, *slots) == 0.0


@pytest.mark.parametrize("clock", [(0, 5, 5), (0, -1, -1), (3, 0, 0)])
def test_with_one_layer_there_is_no_clock_that_could_never_meet_another(clock):
    settings, params, slots = summaries(MEASURES[1])
    at = int(params["path_kernel"]["clock_at"][0])
    slots[1, at : at + 3] = clock
    assert not similarity.are_sound(settings, params, slots)
