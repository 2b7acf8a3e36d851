import json
import random
import sys

import numpy as np
import pytest
from jsonschema import Draft202012Validator

if not sys.platform.startswith("linux"):
    pytest.skip("what a process holds is read from /proc", allow_module_level=True)

from checks.soak.__main__ import soak
from checks.soak.faults import Faults
from checks.soak.measure import Sample, early_and_late
from checks.soak.truth import Truth
from mossar_adapters.demo.body import SKELETON
from mossar_stream.events import to_json
from mossar_stream.segmenter import Segmenter
from mossar_stream.settings import Settings
from mossar_tools.event_schema import event_schema

SETTINGS = Settings(max_pause=3.0)


@pytest.fixture
def motion():
    frames = np.zeros((900, len(SKELETON), 3), np.float32)
    times = np.arange(900) / 60
    frames[:, 1:, 0] = (np.sin(3 * times) * (np.sin(0.7 * times) > 0))[:, None]
    return frames, times


def test_frames_that_repeat_come_late_or_jump_in_time_give_the_events_that_the_rules_call_for(motion):
    frames, times = motion
    times = np.concatenate((times[:500], times[500:] + 100))
    frames, times = Faults(random.Random(3)).deliver(frames, times)
    assert (np.diff(times) <= 0).sum() > 10
    truth, segmenter = Truth(SKELETON, SETTINGS), Segmenter(SKELETON, SETTINGS)
    truth.follow("p1", frames, times)
    truth.leave("p1")
    for frame, time in zip(frames, times, strict=True):
        truth.check(segmenter.push(frame, time))
    truth.check(segmenter.end_take("gap"))
    assert truth.equal > 20
    assert (truth.missing, truth.wrong) == (0, 0)


def test_a_lost_and_a_false_event_are_noticed(motion):
    frames, times = motion
    for change in (slice(0, 300), slice(0, None, 2)):
        truth, segmenter = Truth(SKELETON, SETTINGS), Segmenter(SKELETON, SETTINGS)
        truth.follow("p1", frames, times)
        truth.leave("p1")
        truth.check(segmenter.push(frames[change], times[change]))
        assert truth.missing + truth.wrong > 0
    events = segmenter.end_take("gap")
    assert not truth.knows(events[-2])


def test_growth_is_that_after_the_first_fifth():
    samples = [Sample(k, k, memory, k, 1, 0.0, 0.0) for k, memory in enumerate((0, 50, 60, 60, 61))]
    early, late = early_and_late(samples)
    assert (early.memory, late.memory) == (50, 61)
    assert (early.files, late.files) == (1, 4)


def test_handles_that_a_server_frees_for_a_moment_are_no_growth_later():
    counts = [181, 120, 121, 122] * 3 + [180, 181, 120, 181] * 12
    early, late = early_and_late([Sample(k, k, 1, count, 1, 0.0, 0.0) for k, count in enumerate(counts)])
    assert (early.files, late.files) == (181, 181)


def test_a_few_seconds_of_faults_lose_no_event_and_make_none_up(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("checks.soak.strangers.WAVES", 0)  # they would be all there is time for
    came = []
    check = Truth.check
    monkeypatch.setattr(Truth, "check", lambda truth, events: (came.extend(events), check(truth, events)))
    soak(tmp_path, 4.0, 2)
    out, err = capsys.readouterr()
    assert "0 lost, 0 false" in out, err
    assert "frames were lost" not in err
    validator = Draft202012Validator(event_schema())
    assert len(came) > 100
    assert not [error for event in came for error in validator.iter_errors(json.loads(to_json(event)))]
