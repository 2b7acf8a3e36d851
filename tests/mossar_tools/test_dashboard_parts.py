"""The parts of the dashboard that need no browser."""

import csv
import itertools
import threading
import time
import tomllib
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from mossar_adapters.demo import SKELETON, DemoSource, performance
from mossar_adapters.files import open_recording
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.source import Meta
from mossar_stream import (
    LEVEL_NAMES,
    Frames,
    KeyFrameEvent,
    MossarError,
    Segmenter,
    Settings,
    SettingsError,
    Skeleton,
    segment_recording,
)
from mossar_tools.dashboard.chart import chart
from mossar_tools.dashboard.exports import key_frames_csv
from mossar_tools.dashboard.figures import HIDDEN, balls_of, bones_of
from mossar_tools.dashboard.framing import FIELD, framed, size_teller
from mossar_tools.dashboard.live import MOST_PERFORMERS, LiveShow
from mossar_tools.dashboard.live_picture import excerpt_of
from mossar_tools.dashboard.overview import overview, place
from mossar_tools.dashboard.placement import Placement
from mossar_tools.dashboard.player import Player
from mossar_tools.dashboard.recorded import RecordedShow
from mossar_tools.dashboard.recorder import Recorder
from mossar_tools.dashboard.stretches import stretches_between
from mossar_tools.dashboard.style import OVERVIEW, PANEL, PHONE, SHEET, STRIP
from mossar_tools.dashboard.tables import WAITING, marks_card, state_card
from mossar_tools.dashboard.tasks import Tasks
from mossar_tools.loaded_recording import load_recording
from mossar_tools.marks import Chart, Curve, Mark, Stretch
from mossar_tools.palette import LIGHT
from mossar_tools.settings_file import as_toml


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
        counts.append(sum(mark.kept for mark in seen.glimpses()[0].marks))
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


def test_a_recording_shows_as_many_key_frames_as_asked_for():
    whole = load_recording("demo:?seconds=20&seed=3")
    show = RecordedShow([("p1", whole)], Settings(range="file"))
    total = show.total
    assert total > 10
    for count in (0, 3, total, total + 5):
        show.set_count(count)
        assert show.kept == min(count, total)
        assert show.strength >= 0
    show.set_level("cluster")
    few = show.kept
    show.set_level("posture")
    assert few < show.kept == show.total
    show.change({"sig_threshold": 0.2})
    assert show.total != total
    (glimpse,) = show.glimpses()
    assert np.isfinite(glimpse.body.joints).all()


@pytest.fixture(scope="module")
def medley():
    return load_recording("demo:?seconds=40&seed=5")


@pytest.mark.parametrize("start", ["motion", "cluster"])
def test_a_named_level_of_a_recording_is_that_of_the_command_line(medley, start):
    wanted = {}
    for name in LEVEL_NAMES:
        settings = Settings(level=name, range="file")
        found = segment_recording(
            medley.positions, medley.fps, medley.skeleton, settings, times=medley.times
        ).at(name)
        wanted[name] = [key.frame for key in found.key_frames]
    assert wanted["motion"] != wanted["cluster"]
    show = RecordedShow([("p1", medley)], Settings(level=start, range="file"))
    for name in ("cluster", "motion", "cluster", "posture", "motion"):
        show.set_level(1.0)
        show.set_level(name)
        (part,) = show._parts
        assert [mark.frame for mark in part.chart.kept] == wanted[name], name
        saved = tomllib.loads(as_toml(show.settings, show.level, show.strength))
        again = Settings.build(overrides={**saved["settings"], "level": saved["level"], "range": "file"})
        assert again.resolved() == Settings(level=name, range="file").resolved()


def test_a_number_is_a_strength_of_the_features_in_force(medley):
    show = RecordedShow([("p1", medley)], Settings(level="cluster", range="file"))
    show.set_level("cluster")
    before = show.kept
    show.set_level(show.strength)
    assert (show.kept, show.settings.level) == (before, "cluster")


@pytest.mark.parametrize("names", [["cluster"], ["cluster", "motion", "cluster"], ["cluster", "posture"]])
def test_a_named_level_of_a_stream_is_that_of_the_command_line_from_the_next_take_on(names):
    take = performance(seed=5, seconds=30).frames
    show = LiveShow(Settings())
    pipeline = Pipeline([DemoSource.from_url("demo:")], [], Settings(), views=[show])
    pipeline.naming.performer(0, "p1")
    pipeline.pool.announce("p1", SKELETON, 60)
    pipeline.pool["p1"].push(take.positions[:300], take.times[:300])
    for name in names:
        show.set_level(name)
    show.tick(pipeline)
    segmenter = pipeline.pool["p1"]
    segmenter.reset()
    asked = segmenter.push(take.positions, take.times) + segmenter.end_take()
    begun = Segmenter(SKELETON, Settings(level=names[-1]), performer="p1", fps=60)
    given = begun.push(take.positions, take.times) + begun.end_take()
    assert finals(asked) == finals(given)
    assert len(finals(given)) > 1
    assert show.strength == show.strength_of(names[-1])


def finals(events):
    return [
        (event.frame, event.kind, event.strength)
        for event in events
        if isinstance(event, KeyFrameEvent) and event.status == "final"
    ]


def test_what_is_asked_for_is_done_in_order_and_nothing_is_lost(medley):
    told = []
    tasks = Tasks(told.append)
    show = RecordedShow([("p1", medley)], Settings(range="file"))
    show.set_count(3)
    asking = [
        threading.Thread(target=lambda: [tasks.ask(lambda: show.step_count(1)) for _ in range(4)])
        for _ in range(3)
    ]
    for thread in asking:
        thread.start()
    for thread in asking:
        thread.join()
    tasks.ask(lambda: None).result(20)
    assert show.kept == 15

    go, done = threading.Event(), []
    tasks.ask(lambda: go.wait(20))
    for spot in range(50):
        last = tasks.ask_latest("slider", lambda spot=spot: done.append(spot))
    tasks.ask(lambda: show.change({"window": -1.0}))
    end = tasks.ask(lambda: done.append("end"))
    assert tasks.waits("slider")
    go.set()
    end.result(20)
    assert last.done()
    assert done == [49, "end"]
    assert len(told) == 1
    assert "window" in told[0]
    tasks.close()
    with pytest.raises(SettingsError):
        show.change({"window": -1.0})


def test_whole_recordings_are_drawn_well_formed_and_small(medley):
    show = RecordedShow([("p1", medley)], Settings(range="file"))
    ET.fromstring(overview(show.outlines(), 0.0, 40.0))
    ET.fromstring(place(0.0, 40.0, (5.0, 25.0), 20.0))
    ET.fromstring(chart(show.glimpses(), seeks=True))
    ET.fromstring(marks_card(show.glimpses(), seeks=True))
    ET.fromstring(size_teller())
    times = np.arange(216_000) / 30
    whole = Chart(
        start=0.0,
        end=7200.0,
        threshold=0.1,
        curve=Curve(times, np.sin(times), times, times),
        marks=[Mark("", i / 2, i, "minimum", 0.1, float(i % 7), kept=True) for i in range(14_000)],
        stretches=[Stretch(i / 2, (i + 1) / 2, ("moving", "resting")[i % 2]) for i in range(14_000)],
    )
    assert len(overview([whole], 0.0, 7200.0)) < 200_000


@pytest.mark.parametrize("whole_take", [True, False])
@pytest.mark.parametrize(
    "window",
    [(1920, 1080), (1280, 800), (1000, 700), (760, 900), (600, 800), (390, 844), (320, 568), (844, 390)],
)
def test_who_moves_now_is_in_the_picture_on_any_screen(window, whole_take):
    width, now = 8.06, 8.06 / 2 - 0.95
    position, target = map(np.array, framed(window, width, 3.66, whole_take=whole_take))
    ahead = (target - position) / np.linalg.norm(target - position)
    right = np.cross(ahead, (0, 0, 1))
    right /= np.linalg.norm(right)
    upward = np.cross(right, ahead)
    phone = window[0] < PHONE
    across, down = window[0] - (0 if phone else PANEL), window[1]
    for x, z in itertools.product((now - 0.5, now + 0.5), (0.0, 1.75)):
        there = np.array([x, -1.0, z]) - position
        depth = there @ ahead * np.tan(FIELD / 2) / (down / 2)  # m for a px
        at = (across / 2 + there @ right / depth, down / 2 - there @ upward / depth)
        chart_high = STRIP + (OVERVIEW if whole_take else 0)
        top, bottom = (chart_high, down * (1 - SHEET)) if phone else (0, down - chart_high)
        assert -1 <= at[0] <= across + 1
        assert top - 8 <= at[1] <= bottom + 8 or bottom - top < 0.2 * down


def test_exported_key_frames_are_all_that_the_page_knows(medley, seen):
    show = RecordedShow([("p1", medley)], Settings(range="file"))
    rows = list(csv.DictReader(key_frames_csv(show.marks()).decode().splitlines()))
    assert len(rows) == show.total
    assert sum(row["stands"] == "yes" for row in rows) == show.kept
    assert [float(row["time"]) for row in rows] == sorted(float(row["time"]) for row in rows)
    assert len(key_frames_csv(seen.marks()).splitlines()) > 10


def test_an_exported_picture_shows_the_level_of_the_page(medley):
    pytest.importorskip("matplotlib")
    show = RecordedShow([("p1", medley)], Settings(range="file"))
    show.set_level(0.8)
    performer, one = show.picture(LIGHT)
    show.set_count(3)
    other = show.picture(LIGHT)[1]
    assert performer == "p1"
    assert one[:8] == other[:8] == b"\x89PNG\r\n\x1a\n"
    assert one != other


def test_a_picture_of_a_stream_shows_what_the_page_does(seen):
    pytest.importorskip("matplotlib")
    seen.level = "motion"
    performer, one = seen.picture(LIGHT)
    seen.level = 0.2
    other = seen.picture(LIGHT)[1]
    assert performer == "p1"
    assert one[:8] == other[:8] == b"\x89PNG\r\n\x1a\n"
    assert one != other
    (glimpse,) = seen.glimpses()
    shown = excerpt_of(glimpse, [mark for mark in glimpse.marks if not mark.tentative], (0.2, "level"))
    assert [key.time for key in shown.kept] == [mark.time for mark in glimpse.marks if mark.kept]
    assert (shown.start, shown.end) == (glimpse.start, glimpse.end)
    assert glimpse.end - 0.2 < shown.curve.times[-1] <= glimpse.end  # the curve is that of a moment ago
    known = seen._tracks["p1"].key_poses()
    assert sum(mark.id in known for mark in glimpse.marks) > 10


def test_of_a_stream_without_frames_there_is_no_picture():
    pytest.importorskip("matplotlib")
    with pytest.raises(MossarError, match="nothing to draw yet"):
        LiveShow(Settings()).picture(LIGHT)


def test_a_key_frame_that_is_visited_stays(medley):
    show = RecordedShow([("p1", medley)], Settings(range="file"))
    _, mark = show.marks()[5]
    show.visit(mark.time)
    (glimpse,) = show.glimpses()
    assert (glimpse.now, show.player.paused) == (mark.time, True)


def test_stretches_take_the_state_of_most_of_their_samples():
    times = np.arange(10.0)
    moving = times >= 4
    found = stretches_between([3.0, 20.0], times, moving)
    assert [(s.start, s.end, s.state) for s in found] == [(0, 3, "resting"), (3, 9, "moving")]
    assert stretches_between([1.0], np.zeros(0), np.zeros(0, bool)) == []


def test_the_page_shows_settings_that_others_changed():
    """By `control` settings change in the pipeline; sliders show those of the show, until the page changes them."""
    show = LiveShow(Settings(level="cluster"))
    seen = []

    def tick():
        show.tick(pipeline)
        if not seen:
            pipeline.set({"sig_threshold": 0.11})
        elif len(seen) == 1 and show.settings.sig_threshold == 0.11:
            seen.append(show.level)
            pipeline.set({"level": 0.3})
        elif len(seen) == 2 and show.level == 0.3:
            seen.append(show.settings.bundle)
            pipeline.set({"level": "motion"})
        elif len(seen) == 3 and show.level == "motion":
            seen.append(show.settings.bundle)
            show.change({"sig_threshold": 0.2})
        seen[:] = seen or ["begun"]

    source = DemoSource.from_url("demo:?seconds=60&seed=3", speed=30)
    pipeline = Pipeline([source], [], Settings(level="cluster"), views=[show], tick=tick)
    pipeline.run()
    assert seen == ["begun", "cluster", "cluster", "motion"]  # a number leaves the bundle
    assert show.settings.sig_threshold == pipeline.pool.settings.sig_threshold == 0.2


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
        placement = Placement(Skeleton(names, (-1, 0, 0, 0, 0, 0)))
        pose = upright[:, order] * 100 + 3
        placement.learn(pose.astype(np.float32))
        placed = placement.place(pose.astype(np.float32))
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


def card(show):
    return state_card(show.glimpses(), frozen=False, recording="", frames=0, waits_for=show.waits_for)


class Empty:
    """A live source that knows why nothing comes."""

    name = "webcam:"
    live = True
    knows = "webcam: 7 pictures came without a <person>"

    def items(self):
        for _ in range(40):
            yield None

    def explain(self):
        return self.knows

    def close(self):
        pass


def test_the_dashboard_says_what_a_source_knows_of_why_nobody_is_seen(monkeypatch):
    show, times = LiveShow(Settings()), iter(range(1000))
    monkeypatch.setattr("mossar_tools.dashboard.live.time.monotonic", lambda: float(next(times)))
    source = Empty()
    pipeline = Pipeline([source], [], Settings(), views=[show])
    show.tick(pipeline)
    assert WAITING in card(show)  # not yet: a source may need a moment
    show.tick(pipeline)
    assert "7 pictures came without a &lt;person&gt;" in card(show)
    source.knows = ""
    show.tick(pipeline)
    assert WAITING in card(show)
    show.announce(Meta("p1", Skeleton(("hip", "hand"), (-1, 0))))
    show.tick(pipeline)
    assert WAITING in card(show)
