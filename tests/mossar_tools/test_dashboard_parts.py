"""The parts of the dashboard that need no browser."""

import time
import tomllib
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.files import open_recording
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.source import Meta
from mossar_stream.frames import Frames
from mossar_stream.settings import Settings
from mossar_stream.skeleton import Skeleton
from mossar_tools.dashboard.chart import chart
from mossar_tools.dashboard.figures import HIDDEN, balls_of, bones_of
from mossar_tools.dashboard.live import MOST_PERFORMERS, LiveShow
from mossar_tools.dashboard.player import Player
from mossar_tools.dashboard.recorded import RecordedShow
from mossar_tools.dashboard.recorder import Recorder
from mossar_tools.dashboard.saving import as_toml
from mossar_tools.dashboard.stance import Stance
from mossar_tools.dashboard.stretches import stretches_between
from mossar_tools.options import Options
from mossar_tools.whole import read_whole


@pytest.fixture(scope="module")
def seen():
    """A live show after a minute of the built-in performer."""
    show = LiveShow(Settings())
    source = DemoSource.from_url("demo:?seconds=40&seed=3", speed=40)
    pipeline = Pipeline([source], [], Settings(), views=[show], tick=lambda: show.tick(pipeline))
    pipeline.run()
    return show


def test_what_is_kept_of_a_stream_is_bounded(seen):
    (glimpse,) = seen.glimpses()
    assert glimpse.end - glimpse.start == 20
    assert len(glimpse.curve.times) <= 700
    assert all(mark.time >= glimpse.start for mark in glimpse.marks)
    assert len(glimpse.ghosts) <= 7


def test_more_performers_than_can_be_shown_push_out_the_first():
    show = LiveShow(Settings())
    skeleton = Skeleton(("hip", "hand"), (-1, 0))
    for i in range(MOST_PERFORMERS + 3):
        show.announce(Meta(f"p{i}", skeleton))
    assert list(show._tracks) == [f"p{i}" for i in range(3, MOST_PERFORMERS + 3)]


def test_a_higher_level_leaves_fewer_key_frames_standing(seen):
    counts = []
    for level in (0.0, 0.2, 0.45, 1.0, 50.0):
        seen.level = level
        counts.append(sum(mark.standing for mark in seen.glimpses()[0].marks))
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[2] > counts[-1]


def test_a_frozen_picture_stays(seen):
    seen.level = "motion"
    before = seen.glimpses()
    seen.frozen = True
    seen.level = 5.0
    assert seen.glimpses() is before
    seen.frozen = False
    assert seen.glimpses() is not before


def test_the_chart_is_well_formed_and_quotes_names(seen):
    (glimpse,) = seen.glimpses()
    ET.fromstring(chart([glimpse]))
    other = type(glimpse)(
        **{name: getattr(glimpse, name) for name in glimpse.__struct_fields__} | {"performer": "<b>"}
    )
    assert "&lt;b&gt;" in chart([glimpse, other])
    assert "Waiting" in chart([])


def test_a_recording_shows_as_many_key_frames_as_asked_for():
    whole = read_whole(Options(file="demo:?seconds=20&seed=3"))
    show = RecordedShow([("p1", whole)], Settings(range="file"))
    total = show.total
    assert total > 10
    for count in (0, 3, total, total + 5):
        show.set_count(count)
        assert show.standing == min(count, total)
        assert show.strength >= 0
    show.set_level("cluster")
    few = show.standing
    show.set_level("posture")
    assert few < show.standing == total
    show.change({"sig_threshold": 0.2})
    assert show.total != total
    (glimpse,) = show.glimpses()
    assert np.isfinite(glimpse.body.joints).all()


def test_stretches_take_the_state_of_most_of_their_samples():
    times = np.arange(10.0)
    moving = times >= 4
    found = stretches_between([3.0, 20.0], times, moving)
    assert [(s.start, s.end, s.state) for s in found] == [(0, 3, "resting"), (3, 9, "moving")]
    assert stretches_between([1.0], np.zeros(0), np.zeros(0, bool)) == []


def test_saved_settings_mean_the_same_when_read_back():
    settings = Settings.build(overrides={"level": "cluster", "window": 0.4, "range": "file"})
    saved = tomllib.loads(as_toml(settings, 0.8, 0.8))
    again = Settings.build(overrides={**saved["settings"], "level": saved["level"]}).resolved()
    wanted = settings.replace(range="running").resolved()
    names = [name for name in wanted.__struct_fields__ if name != "level"]
    assert [getattr(again, name) for name in names] == [getattr(wanted, name) for name in names]
    assert again.level == 0.8


def test_a_player_pauses_seeks_and_starts_over():
    player = Player(10.0, 20.0, speed=100.0)
    player.paused = True
    player.seek(15.0)
    assert player.place == 15.0
    player.seek(99.0)
    assert player.place == 20.0
    player.seek(12.0)
    player.paused = False
    time.sleep(0.02)
    assert 10.0 <= player.place <= 20.0
    assert player.place != 12.0


def test_bones_point_from_parent_to_child_and_missing_ones_vanish():
    skeleton = Skeleton(("a", "b", "c"), (-1, 0, 1))
    joints = np.array([[0, 0, 0], [0, 0, -2], [np.nan] * 3], np.float32)
    bones = bones_of(skeleton, joints)
    w, x, y, z = bones.turns[0]
    along = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]) * bones.sizes[0, 2]
    np.testing.assert_allclose(along, [0, 0, -2], atol=1e-6)
    assert bones.sizes[1, 2] == np.float32(HIDDEN)
    assert balls_of(skeleton, joints).sizes[2, 0] == np.float32(HIDDEN)


def test_bodies_stand_upright_on_the_ground_whatever_the_axes():
    names = ("hips", "head", "LeftHand", "RightHand", "LeftFoot", "RightFoot")
    upright = np.array(
        [[0, 0, 0.9], [0, 0, 1.7], [0.5, 0, 0.9], [-0.5, 0, 0.9], [0.1, 0, 0], [-0.1, 0, 0]], np.float32
    )
    for order in ([0, 2, 1], [0, 1, 2]):
        stance = Stance(Skeleton(names, (-1, 0, 0, 0, 0, 0)))
        pose = upright[:, order] * 100 + 3
        stance.learn(pose.astype(np.float32))
        placed = stance.place(pose.astype(np.float32))
        assert placed[1, 2] == pytest.approx(1.7, abs=0.02)
        assert placed[4, 2] == pytest.approx(0.0, abs=0.02)


def test_recordings_are_never_overwritten(tmp_path):
    recorder = Recorder()
    recorder.announce(Meta("p1", Skeleton(("hip", "hand"), (-1, 0)), 30.0))
    for number in (1, 2):
        assert recorder.start(tmp_path) == tmp_path / f"recording-{number}.msk"
        recorder.write(Frames(np.zeros((3, 2, 3), np.float32), np.arange(3) / 30))
        recorder.stop()
    assert open_recording(tmp_path / "recording-1.msk").frame_count == 3


def test_a_full_disk_ends_the_recording_and_not_the_stream(small_disk, tmp_path, caplog):
    recorder = Recorder()
    recorder.announce(Meta("p1", Skeleton(("hip", "hand"), (-1, 0)), 30.0))
    recorder.start(tmp_path)
    with small_disk(20_000):
        for start in range(0, 3000, 100):
            recorder.write(Frames(np.zeros((100, 2, 3), np.float32), np.arange(start, start + 100) / 30))
        recorder.stop()
    assert not recorder.running
    assert "the recording has ended" in caplog.text
    assert 0 < open_recording(tmp_path / "recording-1.msk").frame_count < 3000
