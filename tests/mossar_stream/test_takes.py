"""Takes: a recording is divided as a stream would be, and covers only what is seen."""

import numpy as np
import pytest

from mossar_stream import Segmenter, Settings, Skeleton, segment_recording
from mossar_stream.recording.recording import takes_of

SKELETON = Skeleton(("hips", "hand", "foot"), (-1, 0, 0))
FPS = 60


def moving(seconds=12.0):
    times = np.arange(int(seconds * FPS)) / FPS
    positions = np.zeros((len(times), 3, 3), np.float32)
    positions[:, 1, 1] = 0.5 + 0.4 * np.clip(np.sin(times * 1.5), 0, 1)
    positions[:, 2, 1] = -0.9
    return positions, times


def without(positions, *spans):
    positions = positions.copy()
    for begin, end in spans:
        positions[int(begin * FPS) : int(end * FPS)] = np.nan
    return positions


def spans_of_stream(positions, times, chunk):
    segmenter = Segmenter(SKELETON, Settings())
    events = []
    for start in range(0, len(times), chunk):
        events += segmenter.push(positions[start : start + chunk], times[start : start + chunk])
    events += segmenter.end_take()
    spans = {}
    for event in events:
        if event.__class__.__name__ == "SegmentEvent" and event.status == "final":
            begin, _ = spans.get(event.take, (event.start_time, None))
            spans[event.take] = begin, event.end_time
    return list(spans.values())


CASES = {
    "whole": (),
    "before_and_after": ((0, 2), (10, 12)),
    "middle": ((5, 8.3),),
    "short": ((5, 5.5),),
    "tail": ((11.5, 12),),
    "all_three": ((0, 1.5), (5, 7), (11, 12)),
}


@pytest.mark.parametrize("chunk", [1, 64, 10_000])
@pytest.mark.parametrize("name", CASES)
def test_stream_and_recording_have_the_same_takes(name, chunk):
    positions, times = moving()
    positions = without(positions, *CASES[name])
    result = segment_recording(positions, FPS, SKELETON, times=times, takes=True)
    found = [(times[begin], times[end]) for begin, end in result.takes]
    assert np.array(found) == pytest.approx(np.array(spans_of_stream(positions, times, chunk)))
    seen = np.isfinite(positions).all(axis=(1, 2))
    for begin, end in result.takes:
        assert seen[begin]
        assert seen[end]
    segments = result.segments
    assert [s.start_frame for s in segments if s.start_frame in {b for b, _ in result.takes}] == [
        b for b, _ in result.takes
    ]
    for segment in segments:
        assert any(b <= segment.start_frame <= segment.end_frame <= e for b, e in result.takes)
    assert all(times[key.frame] == pytest.approx(key.time) for key in result.key_frames)


def test_a_step_in_time_divides_a_recording_as_well():
    positions, times = moving()
    times = times + np.where(np.arange(len(times)) >= 300, 5.0, 0.0)
    assert takes_of(positions, times, 1.0) == [(0, 300), (300, len(times))]
    times[500:] -= 100.0
    assert takes_of(positions, times, 1.0) == [(0, 300), (300, 500), (500, len(times))]
    assert segment_recording(positions, FPS, SKELETON, times=times).takes == [(0, len(times) - 1)]


def test_counts_levels_and_limbs_go_over_all_takes():
    positions, times = moving(24.0)
    positions = without(positions, (10, 13))
    result = segment_recording(positions, FPS, SKELETON, times=times, takes=True)
    assert len(result.takes) == 2
    for count in range(len(result.key_frames) + 2):
        found = result.at(count=count)
        assert len(found.key_frames) == min(count, len(result.key_frames))
        assert len(found.segments) == len(found.key_frames) + 2
    assert result.segments == result.at("motion").segments
    assert sorted(key.frame for key in result.hierarchy) == [key.frame for key in result.key_frames]
    few = segment_recording(positions, FPS, SKELETON, Settings(max_key_frames=2), times=times, takes=True)
    assert len(few.at("motion").key_frames) <= 2
    with pytest.raises(ValueError, match="not be negative"):
        result.at(count=-1)
    with pytest.raises(ValueError, match="a level or a count"):
        result.at()


def test_nobody_at_all_is_one_empty_take():
    positions, times = moving(2.0)
    result = segment_recording(np.full_like(positions, np.nan), FPS, SKELETON, times=times, takes=True)
    assert result.key_frames == []
