"""A named level is one thing everywhere, or it is refused and said how to get it."""

import numpy as np
import pytest

from mossar_stream import (
    KeyFrameEvent,
    Performers,
    Segmenter,
    Settings,
    SettingsError,
    Skeleton,
    segment_recording,
)

SKELETON = Skeleton(("hip", "hand", "foot"), (-1, 0, 0))


def moves(count=1200):
    times = np.arange(count) / 60
    positions = np.zeros((count, 3, 3), np.float32)
    positions[:, 1, 0] = np.where(times % 4 < 2, np.sin(3 * times), 0.4 * np.sin(9 * times))
    positions[:, 2, 1] = 0.3 * np.sin(times * times / 3)
    return positions, times


def final(events):
    return [(e.frame, e.kind) for e in events if isinstance(e, KeyFrameEvent) and e.status == "final"]


@pytest.mark.parametrize("level", ["cluster", "posture"])
def test_a_result_refuses_a_level_that_it_was_not_made_for(level):
    positions, times = moves()
    result = segment_recording(positions, skeleton=SKELETON, times=times)
    with pytest.raises(SettingsError, match=rf"Settings\(level='{level}'\)"):
        result.at(level)
    assert result.at("motion").key_frames
    assert len(result.at(0).key_frames) >= len(result.at("motion").key_frames)


def test_a_level_by_change_gives_what_the_setting_gives():
    positions, times = moves()
    changed, made = Segmenter(SKELETON), Segmenter(SKELETON, Settings(level="cluster"))
    with pytest.raises(SettingsError, match="starts a new take"):
        changed.level = "cluster"
    assert changed.level == "motion"
    changed.change(level="cluster")
    one, other = (final([*s.push(positions, times), *s.end_take()]) for s in (changed, made))
    assert one == other
    assert one
    assert changed.settings == made.settings


def test_a_pool_refuses_or_changes_all():
    pool = Performers()
    pool.announce("ann", SKELETON)
    with pytest.raises(SettingsError, match="starts a new take"):
        pool.level = "cluster"
    assert pool.level == pool["ann"].level == "motion"
    pool.change(level="cluster")
    pool.announce("bob", SKELETON)
    assert pool.level == pool["ann"].level == pool["bob"].level == "cluster"
    assert pool["ann"].settings == pool["bob"].settings == Settings(level="cluster")
