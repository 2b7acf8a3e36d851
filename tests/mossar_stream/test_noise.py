"""A sensor's noise is not motion."""

import pytest

from mossar_adapters.demo import performance
from mossar_stream import KeyFrameEvent, Segmenter, Settings

STILL = "stand:20"
MOVES = ("punch_left", "kick_right")


def confirmed(take):
    segmenter = Segmenter(take.skeleton, Settings(), fps=take.fps)
    events = segmenter.push(take.frames) + segmenter.end_take()
    return [e.time for e in events if isinstance(e, KeyFrameEvent) and e.status == "confirmed"]


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("noise", [0.001, 0.005])
def test_standing_still_before_motion_gives_at_most_two_key_frames(noise, fps):
    for seed in (1, 2, 3):
        take = performance(seed, fps=fps, moves=(STILL, *MOVES), noise=noise)
        moments = confirmed(take)
        assert sum(time < take.cuts[0].time - 0.5 for time in moments) <= 2
        assert any(abs(time - take.cuts[0].time) < 0.5 for time in moments)


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("noise", [0.001, 0.005])
def test_standing_still_after_motion_gives_at_most_two_key_frames(noise, fps):
    for seed in (1, 2, 3):
        take = performance(seed, fps=fps, moves=(*MOVES, STILL), noise=noise)
        assert sum(time > take.cuts[-1].time + 0.5 for time in confirmed(take)) <= 2


def test_the_papers_preset_leaves_noise_alone():
    assert Settings.build("paper").noise_margin == 0.0
