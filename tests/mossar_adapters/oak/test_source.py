"""The source before the stage of the conftest: names, missing joints, losses, wrong input."""

import logging
import os
import subprocess
import sys
import time
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_adapters.oak.camera import load_sdk
from mossar_adapters.oak.source import CONFIDENCE, SKELETON, OakSource
from mossar_adapters.oak.types import CameraError, CameraLost, OakOptions
from mossar_adapters.people import PeopleSource
from mossar_adapters.source import Meta
from mossar_stream import Frames, SettingsError


def ran(program):
    """Run a program in a process of its own."""
    path = os.pathsep.join(filter(None, sys.path))
    return subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env={**os.environ, "PYTHONPATH": path},
    )


def test_people_keep_their_names_while_their_order_in_the_message_changes(studio):
    take = performance(seed=3, fps=studio.FPS, seconds=1.0, moves=("rest:1",))
    body = studio.coco(take)
    left, right = body - np.array([0.7, 0, 0]), body + np.array([0.7, 0, 0])
    pictures = [
        (i, studio.START + i / studio.FPS, [left[i], right[i]] if i % 2 else [right[i], left[i]])
        for i in range(len(body))
    ]
    _, items = studio.shown(studio.Stage(), pictures)
    assert [item.performer for item in items if isinstance(item, Meta)] == ["p1", "p2"]
    one, two = studio.frames_of(items, "p1"), studio.frames_of(items, "p2")
    assert len(one) == len(two) == len(body)
    assert all(f.positions[0, 17, 0] > 0.5 for f in one)
    assert all(f.positions[0, 17, 0] < -0.5 for f in two)


def crossing(studio, body):
    """Yield pictures of two people who change sides; who is covered is not found; the second leaves and comes back."""
    at_origin = body - body[11:13].mean(0) * (1, 0, 1)
    for number in range(120):
        side = 0.9 * (2 * number / 71 - 1) if number < 72 else 0.9
        people = [at_origin + np.array(place) for place in ((side, 0, -2.8), (-side, 0, -3.6))]
        if abs(side) < 0.15 or 72 <= number < 100:
            people.pop()
        yield number, studio.START + number / studio.FPS, people[:: -1 if number % 2 else 1]


def test_people_who_cross_and_who_come_back_keep_their_names(studio):
    stage = studio.Stage(noise=0.1, holes=0.05, jitter=0.7)
    pictures = list(crossing(studio, studio.standing()))
    _, items = studio.shown(stage, pictures)
    assert [item.performer for item in items if isinstance(item, Meta)] == ["p1", "p2"]
    one, two = studio.frames_of(items, "p1"), studio.frames_of(items, "p2")
    assert len(one) == len(pictures)
    assert len(two) == sum(len(people) == 2 for _, _, people in pictures)
    assert all(f.positions[0, 17, 2] == pytest.approx(-2.8, abs=0.2) for f in one)
    assert all(f.positions[0, 17, 2] == pytest.approx(-3.6, abs=0.3) for f in two)


def away_and_back(studio, body):
    """Yield pictures of a tall and a short person; both leave for 4 s and come back at each other's side."""
    at_origin = body - body[11:13].mean(0) * (1, 0, 1)
    tall, short = at_origin * 1.05, at_origin * 0.8
    for number in range(60):
        side = 0.7 if number < 20 else -0.7
        at = number if number < 20 else number + 96
        people = [tall + np.array((side, 0, -3.0)), short + np.array((-side, 0, -3.0))]
        yield number, studio.START + at / studio.FPS, people[:: 1 if number < 20 else -1]


def test_slots_know_who_comes_back_where_the_numbers_of_the_camera_follow_places(studio):
    stage = studio.Stage(noise=0.05)
    _, items = studio.shown(stage, list(away_and_back(studio, studio.standing())))

    class Shown:
        name, live = "oak:", True

        def items(self):
            yield from items

    def height(frame):
        return np.nanmax(frame.positions[0, :, 1]) - np.nanmin(frame.positions[0, :, 1])

    assert height(studio.frames_of(items, "p1")[-1]) < 1.4 < height(studio.frames_of(items, "p1")[0])
    slots = [item for item in PeopleSource(Shown(), 2).items() if isinstance(item, Frames)]
    for name, low, high in (("p1", 1.4, 2.0), ("p2", 1.0, 1.4)):
        own = [item for item in slots if item.performer == name]
        assert len(own) == 60
        assert all(low < height(item) < high for item in own)


def test_the_root_is_a_virtual_pelvis_between_the_hips_and_y_is_up(studio):
    _, items = studio.shown(studio.Stage(), [(0, studio.START, [studio.standing()])])
    meta, frame = items
    assert meta.skeleton == SKELETON
    assert SKELETON.names[SKELETON.root] == "pelvis"
    joints = dict(zip(SKELETON.names, frame.positions[0], strict=True))
    assert joints["pelvis"] == pytest.approx((joints["left_hip"] + joints["right_hip"]) / 2, abs=1e-6)
    assert joints["nose"][1] > joints["pelvis"][1] > joints["left_ankle"][1]
    assert joints["left_shoulder"][0] > joints["right_shoulder"][0]  # facing the camera
    assert joints["nose"][2] > joints["left_shoulder"][2]
    assert joints["pelvis"][2] == pytest.approx(-studio.DISTANCE, abs=0.3)


def test_one_missing_hip_is_replaced_by_the_width_seen_before(studio):
    stage = studio.Stage()
    source = OakSource(connect=studio.opened(stage.camera))
    body = studio.standing()
    pictures = [(0, studio.START, [body]), (1, studio.START + 0.04, [body])]
    send = stage.detection
    hide = iter((False, True))

    def without_right_hip(u, v, sure):
        sure = sure.copy()
        sure[12] = 0.1 if next(hide) else 0.9
        sure[11] = 0.9
        return send(u, v, sure)

    stage.detection = without_right_hip
    _, items = studio.shown(stage, pictures, source)
    both, single = studio.frames_of(items)
    assert np.isnan(single.positions[0, 12]).all()
    assert single.positions[0, 17] == pytest.approx(both.positions[0, 17], abs=0.002)


def test_joints_without_depth_are_missing_at_confidence_zero(studio):
    stage = studio.Stage(holes=1.0)
    source, items = studio.shown(stage, [(0, studio.START, [studio.standing()])])
    assert items == []
    assert source.counters.no_depth == 17
    assert "17 were without depth" in source.explain()


def test_joints_that_the_network_is_unsure_of_are_missing(studio):
    stage = studio.Stage()
    source, items = studio.shown(stage, [(0, studio.START, [studio.standing()], CONFIDENCE - 0.01)])
    assert items == []
    assert source.counters.unsure == 17
    source, items = studio.shown(studio.Stage(), [(0, studio.START, [studio.standing()], CONFIDENCE + 0.01)])
    assert np.isfinite(items[1].positions).all()
    assert items[1].confidence == pytest.approx(CONFIDENCE + 0.01)


def test_a_network_that_gives_no_confidence_is_believed(studio):
    _, items = studio.shown(studio.Stage(), [(0, studio.START, [studio.standing()], -1.0)])
    assert (items[1].confidence == 1).all()


def test_a_joint_on_the_wall_behind_is_missing(studio):
    stage = studio.Stage()
    body = studio.standing()
    stage.measured = lambda solid: np.where(
        np.arange(studio.WIDTH) > studio.project(body)[0][9] - 12, studio.WALL * 1000, solid
    )
    source, items = studio.shown(stage, [(0, studio.START, [body], 0.9)])
    assert source.counters.far_off >= 1
    assert np.isnan(items[1].positions[0, 9]).all()


def test_an_empty_picture_gives_no_frames_and_says_that_nobody_was_there(studio):
    source, items = studio.shown(studio.Stage(), [(i, studio.START + i, []) for i in range(3)])
    assert items == []
    assert source.counters.received == 3
    assert "3 pictures came without a person" in source.explain()


def test_gaps_in_the_sequence_numbers_are_counted(studio):
    body = studio.standing()
    source, _ = studio.shown(
        studio.Stage(), [(n, studio.START + n / studio.FPS, [body]) for n in (5, 6, 9, 10, 20)]
    )
    assert source.counters.gaps == 2 + 9


def test_times_are_the_hosts_monotonic_clock(studio):
    now = time.monotonic()
    _, items = studio.shown(studio.Stage(), [(0, now, [studio.standing()])])
    assert items[1].times[0] == pytest.approx(now, abs=1e-6)


def test_a_unit_given_by_the_user_replaces_that_of_the_messages(studio):
    _, (_, right) = studio.shown(studio.Stage(unit="mm"), [(0, studio.START, [studio.standing()])])
    source, (_, large) = studio.shown(studio.Stage(unit="cm"), [(0, studio.START, [studio.standing()])])
    assert large.positions[0, 17] == pytest.approx(10 * right.positions[0, 17])
    assert source.counters.far_off > 0


def test_people_with_other_joints_are_counted_and_the_stream_goes_on(studio):
    stage = studio.Stage()
    source = OakSource(connect=studio.opened(stage.camera))
    send, few = stage.detection, iter((5, 17))

    def some(u, v, sure):
        count = next(few)
        return send(u[:count], v[:count], sure[:count])

    stage.detection = some
    _, items = studio.shown(
        stage, [(0, studio.START, [studio.standing()]), (1, studio.START + 1, [studio.standing()])], source
    )
    assert len(studio.frames_of(items)) == 1
    assert source.counters.malformed == 1
    assert "5 joints" in source.explain()


def test_joints_are_measured_in_the_depth_of_their_own_moment_though_the_network_drops_pictures(studio):
    stage, body = studio.Stage(), studio.standing()
    seen = studio.project(body)
    solid = studio.draw([seen])
    for number in range(50):  # everything is a centimetre farther in each picture
        stage.send_depth(number, studio.START + number / studio.FPS, solid + 10 * number)
    for number in (0, 3, 4, 7):  # the colour camera is not quite in step with the stereo pair
        people = [stage.detection(seen[0], seen[1], np.full(17, 0.9))]
        stage.send_detections(number, studio.START + (number + 0.2) / studio.FPS, people)
    pictures = [stage.camera.get(5.0) for _ in range(4)]
    stage.camera.close()
    assert [picture.number for picture in pictures] == [0, 3, 4, 7]
    farther = [picture.people[0][0, 2] - pictures[0].people[0][0, 2] for picture in pictures]
    assert farther == pytest.approx([0, 0.03, 0.04, 0.07], abs=1e-6)
    assert pictures[1].time == pytest.approx(studio.START + 3.2 / studio.FPS, abs=1e-6)


def test_a_message_that_the_sdk_stumbles_over_loses_the_camera_and_does_not_abort(studio):
    stage, body = studio.Stage(), studio.standing()
    message = studio.dai.ImgDetections()  # without the view of the camera that it belongs to
    message.detections = [stage.detection(*studio.project(body)[:2], np.full(17, 0.9))]
    message.setTimestamp(timedelta(seconds=studio.START))
    stage.send_depth(0, studio.START, studio.draw([]))
    stage.detections.send(message)
    with pytest.raises(CameraLost, match="its stream ended"):
        stage.camera.get(5.0)
    stage.camera.close()


def test_a_lost_camera_is_told_of_waited_for_and_comes_back(studio, monkeypatch, caplog):
    monkeypatch.setattr("mossar_adapters.oak.source._SHORTEST_PAUSE", 0.01)
    body = studio.standing()
    stages = [studio.Stage(), studio.Stage()]
    waiting = iter(stages)
    attempts = []

    def connect(*_):
        attempts.append(1)
        if len(attempts) == 2:
            raise CameraError("No OAK camera found")
        return next(waiting).camera

    source = OakSource(connect=connect)
    items = source.items()
    assert next(items) is None
    stages[0].send(7, studio.START, [body])
    assert isinstance(next(item for item in items if item is not None), Meta)
    assert isinstance(next(items), Frames)
    with caplog.at_level(logging.WARNING, "mossar.oak"):
        stages[0].pipeline.stop()
        while len(attempts) < 3:
            assert next(items) is None
        stages[1].send(0, studio.START + 5, [body])
        frame = next(item for item in items if item is not None)
    source.close()
    assert frame.times[0] == studio.START + 5
    assert source.counters.gaps == 0
    news = [record.getMessage() for record in caplog.records if record.name == "mossar.oak"]
    assert ["was lost" in news[0], "is back" in news[1], len(news)] == [True, True, 2]
    assert list(items) == []


def test_a_camera_that_is_lost_before_its_first_picture_is_tried_less_and_less(studio, monkeypatch):
    monkeypatch.setattr("mossar_adapters.oak.source._SHORTEST_PAUSE", 0.1)
    attempts = []

    def connect(*_):
        attempts.append(time.monotonic())
        stage = studio.Stage()
        stage.pipeline.stop()
        return stage.camera

    source = OakSource(connect=connect)
    items = source.items()
    while len(attempts) < 4:
        assert next(items) is None
    source.close()
    assert attempts[3] - attempts[2] >= 0.4 > attempts[1] - attempts[0]


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="the system does not name threads")
def test_the_threads_of_a_closed_camera_have_ended(studio):
    def threads():
        return [path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm")]

    stage, body = studio.Stage(), studio.standing()
    seen = studio.project(body)
    assert any(name.startswith("Sync") for name in threads())
    for number in range(60):
        stage.send_depth(number, studio.START + number / studio.FPS, studio.draw([seen]))
    stage.send_detections(59, studio.START + 59 / studio.FPS, [stage.detection(*seen[:2], np.full(17, 0.9))])
    stage.camera.close()
    assert not any(name.startswith("Sync") for name in threads())


def test_a_camera_that_falls_silent_is_lost(studio, monkeypatch):
    monkeypatch.setattr("mossar_adapters.oak.camera._FIRST_PICTURE", 0.05)
    camera = studio.Stage().camera
    time.sleep(0.06)
    with pytest.raises(CameraLost, match="no pictures"):
        camera.get(0.01)
    camera.close()
    with pytest.raises(CameraLost):
        camera.get(0.01)


def test_an_error_in_our_code_reaches_the_reader_instead_of_aborting_the_process():
    source = OakSource(connect=lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        list(source.items())
    source.close()
    source.close()


@pytest.mark.parametrize(
    ("end", "status"), [("", 0), ("raise SystemExit(7)", 7), ("raise RuntimeError('ours')", 1)]
)
def test_a_program_that_ends_while_the_camera_runs_does_not_abort(studio, end, status):
    program = (
        f"import sys; sys.path.insert(0, {str(Path(studio.__file__).parent)!r})\n"
        "import conftest as studio\n"
        "from mossar_adapters.oak.source import OakSource\n"
        "stage = studio.Stage()\n"
        "items = OakSource(connect=studio.opened(stage.camera)).items()\n"
        "next(items); stage.send(0, 1.0, [studio.standing()]); next(items)\n"
        f"{end}"
    )
    done = ran(program)
    assert done.returncode == status, done.stderr
    assert "Abort" not in done.stderr


def test_frames_that_nobody_reads_are_dropped_and_counted(studio, monkeypatch):
    monkeypatch.setattr("mossar_adapters.oak.source._CAPACITY", 3)
    stage, body = studio.Stage(), studio.standing()
    source = OakSource(connect=studio.opened(stage.camera))
    items = source.items()
    assert next(items) is None
    for number in range(6):
        stage.send(number, studio.START + number, [body])
        studio.await_received(source, number + 1)
    limit = time.monotonic() + 5
    # It is counted before the frame that takes the place comes.
    while source.counters.late < 3 and time.monotonic() < limit:
        time.sleep(0.001)
    assert isinstance(next(items), Meta)
    assert [next(items).times[0] - studio.START for _ in range(3)] == [3, 4, 5]
    assert source.counters.late == 3
    source.close()


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("oak:?device=1&speed=3", "model, device, fps, unit, performer, confidence"),
        ("oak:?fps=fast", "fps must be a number"),
        ("oak:?fps=1000", "1 to 120"),
        ("oak:?confidence=2", "0 to 1"),
        ("oak:?unit=mile", "auto, m, cm, mm, inch"),
        ("oak:?model=/nowhere/pose.tar.xz", "no such model archive"),
        ("oak:?model=./pose.blob", r"an archive \(.tar.xz .* or a name at the maker's hub"),
        ("oak://192.168.1.44", r"oak:\?device="),
    ],
)
def test_wrong_urls_name_what_is_legal(url, words):
    with pytest.raises(SettingsError, match=words) as error:
        OakSource.from_url(url)
    assert "\n" not in str(error.value)


def test_a_url_says_which_camera_model_rate_unit_and_name():
    source = OakSource.from_url(
        "oak:?model=luxonis/pose:coco-640x352&device=10.0.0.7&fps=15&unit=mm&performer=Ann&confidence=0.3"
    )
    assert source.options == OakOptions("luxonis/pose:coco-640x352", "10.0.0.7", 15.0, "mm")
    assert source.name.startswith("oak:?model=")


def test_without_a_camera_the_error_is_one_clear_line():
    pytest.importorskip("depthai")
    if load_sdk().Device.getAllConnectedDevices():
        pytest.skip("a camera is connected")
    with pytest.raises(CameraError, match="No OAK camera found: plug one in") as error:
        list(OakSource.from_url("oak:").items())
    assert "\n" not in str(error.value)


def test_without_the_sdk_the_error_names_the_extra():
    program = (
        "import sys; sys.modules['depthai'] = None\n"
        "from mossar_adapters.oak.source import OakSource\n"
        "from mossar_adapters.oak.check import check\n"
        "print(check()[0].splitlines()[0])\n"
        "try:\n    list(OakSource.from_url('oak:').items())\n"
        "except Exception as error:\n    print(type(error).__name__, error)"
    )
    done = ran(program)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 2
    assert all("pip install 'mossar-stream[oak]'" in line for line in lines)
    assert lines[1].startswith("MossarError")
