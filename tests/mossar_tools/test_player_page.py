"""The page for players and clients, without a browser: what it counts, what it says, and whom it answers."""

import contextlib
import json
import socket
import struct
import threading
import time
import urllib.error
import urllib.request
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_adapters.joint_sets import BLAZEPOSE_33
from mossar_adapters.pose.types import SKELETON, Body
from mossar_stream import (
    FollowEvent,
    Frames,
    MossarError,
    MoveEvent,
    Moves,
    PoseEvent,
    RepetitionEvent,
    Segmenter,
    Settings,
    Skeleton,
)
from mossar_tools.commands import run
from mossar_tools.dashboard.glimpse import FollowedMove
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.tables import state_card
from mossar_tools.dashboard.tally import Tally
from mossar_tools.dashboard.track import Track
from mossar_tools.options import PageOptions, Segmenting, Streaming
from mossar_tools.player_page import page as page_module
from mossar_tools.player_page.opening import wanted_names, wants_player_page
from mossar_tools.player_page.outline import outline_of
from mossar_tools.player_page.page import PlayerPage
from mossar_tools.player_page.server import LINE, Asked, PlayerServer, Window
from mossar_tools.player_page.state import state_of
from mossar_tools.player_page.verdicts import OFF, Judge

FPS = 60.0
SOON = 30.0  # s


# Outlines: what is drawn of a skeleton.


def standing(skeleton):
    """Return a pose with each joint at a place of its own, (J, 3) m."""
    return np.random.default_rng(1).normal(0, 0.5, (len(skeleton), 3)).astype(np.float32)


def test_a_body_is_drawn_without_face_and_fingers():
    outline = outline_of(SKELETON)
    drawn = {outline.joints[end] for bone in outline.bones for end in bone}
    assert {"left_knee", "right_wrist", "head", "hips", "chest"} <= drawn
    assert len(outline.places) == len(outline.joints) < len(SKELETON)
    assert len(outline.trunk) == 4
    assert outline.parts[outline.drawn()["back"]] == "back"
    pose = standing(SKELETON)
    hips = (pose[BLAZEPOSE_33.index("left_hip")] + pose[BLAZEPOSE_33.index("right_hip")]) / 2
    np.testing.assert_allclose(outline.points(pose)[outline.joints.index("hips")], hips, atol=1e-6)


def test_a_skeleton_of_unknown_names_is_drawn_bone_by_bone():
    rope = Skeleton(("a", "b", "c"), (-1, 0, 1))
    outline = outline_of(rope)
    assert outline.bones == ((0, 1), (1, 2))
    assert outline.trunk == ()
    np.testing.assert_array_equal(outline.points(standing(rope)), standing(rope))
    assert outline.strays(standing(rope), standing(rope), outline) == pytest.approx([0, 0], abs=0.1)


def test_the_angle_of_each_bone_with_the_example_is_measured_across_joint_sets():
    outline = outline_of(SKELETON)
    pose = standing(SKELETON)
    other = pose.copy()
    knee, ankle = BLAZEPOSE_33.index("left_knee"), BLAZEPOSE_33.index("left_ankle")
    shin = pose[ankle] - pose[knee]
    aside = np.cross(shin, (0.0, 0.0, 1.0))
    other[ankle] = pose[knee] + aside / np.linalg.norm(aside)
    angles = dict(zip(outline.parts, outline.strays(pose, other, outline), strict=True))
    assert angles["left foot"] == pytest.approx(90, abs=0.1)
    assert angles["left knee"] == pytest.approx(0, abs=0.1)
    fewer = Skeleton(
        ("left_shoulder", "right_shoulder", "left_hip", "right_hip", "left_knee", "nose"), root=-1
    )
    partial = outline.strays(pose, standing(fewer), outline_of(fewer))
    known = dict(zip(outline.parts, np.isfinite(partial), strict=True))
    assert known["left knee"]
    assert not known["left foot"]


# Counts.


def follow(name, status="done"):
    return FollowEvent(
        performer="p1",
        id="p1/follow/0/1",
        rev=1,
        name=name,
        status=status,
        take=0,
        count=1,
        start=0.0,
        time=1.0,
        progress=1.0,
        tempo=1.0,
        certainty=1.0,
        deviation=3.0,
        limbs={"left_leg": 3.0},
        joint="left_knee",
        range=None,
        score=0.9,
        decided_time=1.0,
    )


def move(name, status="confirmed"):
    return MoveEvent(
        performer="p1",
        id="p1/move/0/1",
        rev=1,
        name=name,
        status=status,
        take=0,
        start=0.0,
        end=1.0,
        score=0.9,
        limb="left_leg",
        decided_time=1.0,
    )


def repetition(take, total, count=2, tempo=24.0):
    return RepetitionEvent(
        performer="p1",
        id=f"p1/{take}/r{total}",
        rev=1,
        status="counted",
        take=take,
        channel="body",
        count=count,
        total=total,
        period=2.5,
        tempo=tempo,
        start=0.0,
        end=1.0,
        amplitude=0.5,
        joint="left_knee",
        decided_time=1.0,
    )


def tallied(*events):
    tally = Tally()
    for event in events:
        tally.add(event)
    return tally


def test_counts_go_on_when_a_take_ends():
    tally = tallied(repetition(0, 1), repetition(0, 2), repetition(1, 1), follow("squat"), follow("squat"))
    assert tally.count.repetitions == 3
    assert tally.count.followed == {"squat": 2}
    assert tally.count.tempo == 24.0


def test_what_is_withdrawn_or_under_way_is_not_counted():
    tally = tallied(follow("squat", "progress"), follow("squat", "left"), move("kick"))
    assert tally.count.moves == {"kick": 1}
    tally.add(move("kick", "final"))
    assert tally.count.moves == {"kick": 1}
    tally.add(move("kick", "withdrawn"))
    assert tally.count.moves == {"kick": 0}
    assert tally.count.followed == {}


def test_a_count_begins_again_within_a_take():
    tally = tallied(repetition(0, 1), repetition(0, 2), follow("squat"), move("kick"))
    tally.begin_again()
    assert tally.count.repetitions is None
    assert tally.count.followed == tally.count.moves == {}
    tally.add(repetition(0, 3))
    assert tally.count.repetitions == 1


# What is shown of a performer.


@pytest.fixture(scope="module")
def take():
    return performance(2, fps=FPS, moves=["rest:2", "squat", "squat", "squat", "rest:2"])


@pytest.fixture(scope="module")
def moves(take):
    found = Moves(take.skeleton)
    found.add("squat", take.frames.positions[round(3.4 * FPS) : round(4.6 * FPS)], FPS)
    return found


def glimpses_of(take, positions, settings=None, moves=None, follow=()):
    """Yield what there is to see after each tenth of a second."""
    segmenter = Segmenter(take.skeleton, settings or Settings(), moves=moves, follow=follow)
    track = Track("p1", take.skeleton)
    for i, now in enumerate(take.frames.times.tolist()):
        for event in segmenter.push(positions[i], now):
            track.add_event(event)
        track.add_frames(Frames(positions[i : i + 1], np.array([now]), performer="p1"))
        track.add_sample(segmenter.state)
        track.set_following(segmenter.following, moves, segmenter.settings.up)
        if i % 6 == 5:
            yield track.glimpse(1.0, [])


def shown_of(glimpses):
    judge = Judge()
    return [state_of(glimpse, judge, 0.0) for glimpse in glimpses]


@pytest.fixture(scope="module")
def squats(take, moves):
    settings = Settings(repetitions=True)
    glimpses = list(glimpses_of(take, take.frames.positions, settings, moves, follow=True))
    return glimpses, shown_of(glimpses)


def test_there_is_one_count_that_of_the_followed_move(squats):
    glimpses, states = squats
    counts = [state["count"] for state in states]
    assert counts == sorted(counts)
    assert counts[-1] == glimpses[-1].followed_moves[0].count >= 4
    assert {state["title"] for state in states} == {"squat"}
    assert glimpses[-1].count.repetitions  # counted, but not shown beside
    assert glimpses[-1].count.moves.get("squat")  # recognised, but not counted beside
    assert states[-1]["others"] == []
    card = state_card([glimpses[-1]], frozen=False, recording="", frames=0)
    assert "mossar-repetitions" not in card  # nor on the dashboard


def test_the_ring_the_verdict_and_the_tempo_follow_the_performance(squats):
    _, states = squats
    assert states[0]["verdict"] == "ready"
    assert states[0]["tempo"] == ""
    assert len({round(state["progress"], 1) for state in states if state["progress"] is not None}) > 4
    done = states[-1]
    assert (done["verdict"], done["kind"]) == ("good", "good")
    assert done["tempo"].endswith("×")  # noqa: RUF001 - as it is shown


def test_the_part_that_strays_is_named_with_its_angle(take, moves):
    names, positions = list(take.skeleton.names), take.frames.positions.copy()
    elbow, hand = names.index("LeftLowerArm"), names.index("LeftHand")
    length = np.linalg.norm(positions[0, hand] - positions[0, elbow])
    up = np.argmax(np.ptp(positions[0], axis=0))
    positions[:, hand] = positions[:, elbow]
    positions[:, hand, up] += length  # the forearm straight up throughout
    states = shown_of(glimpses_of(take, positions, moves=moves, follow=True))
    last = states[-1]
    assert last["count"] >= 1
    assert last["kind"] == "off"
    name, angle = last["verdict"].removesuffix("° off").rsplit(" ", 1)
    assert name == "left hand"
    assert float(angle) >= OFF
    during = [state for state in states if state["strays"] and state["progress"]]
    bone = outline_of(take.skeleton).parts.index("left hand")
    assert max(state["strays"][bone] for state in during) > OFF
    assert all(state["example"]["points"] for state in during)


def test_a_performance_that_is_given_up_changes_no_verdict(squats):
    glimpses, states = squats
    # At rest, after the last squat.
    assert any(g.followed_moves[0].progress is not None for g in glimpses[-25:])
    assert {state["verdict"] for state in states[-25:]} == {"good"}
    assert all(state["strays"] is None for state in states[-20:])


def test_a_followed_move_without_known_joints_is_judged_by_its_limb(squats):
    glimpses, _ = squats
    rope = Skeleton(("a", "b"), (-1, 0))
    judge, texts = Judge(), []
    for made in (
        FollowedMove("reach", 0, 0.9, "left_arm", 21.0),
        FollowedMove("reach", 1, None, "left_arm", 22.0, 1.0, 0.7),
    ):
        glimpse = msgspec.structs.replace(glimpses[-1], skeleton=rope, followed_moves=[made], overlay=None)
        texts.append(judge.judge(glimpse).text)
    assert texts == ["left arm 21° off", "left arm 22° off"]


def test_repetitions_recognised_moves_and_held_poses_are_shown_where_nothing_is_followed(squats):
    glimpses, _ = squats
    still = msgspec.structs.replace(glimpses[0], followed_moves=[], moving=False)

    def state(*events):
        return state_of(msgspec.structs.replace(still, count=tallied(*events).count), Judge(), 75.4)

    shown = state(repetition(0, 4))
    assert (shown["title"], shown["count"], shown["tempo"]) == ("repetitions", 4, "24 a minute")
    assert (shown["verdict"], shown["seconds"]) == ("resting", 75)
    shown = state(move("kick"), move("wave"), move("kick"))
    assert (shown["title"], shown["count"], shown["others"]) == ("kick", 2, [["wave", 1]])
    held = PoseEvent(
        performer="p1",
        id="p1/pose/0/1",
        rev=1,
        name="plank",
        status="held",
        take=0,
        start=0.0,
        seconds=12.2,
        deviation=3.0,
        limbs={},
        joint="left_knee",
        decided_time=12.2,
    )
    assert state(held)["verdict"] == "plank 12 s"
    nothing = state()
    assert nothing["count"] is None
    assert nothing["title"] == ""


def test_points_are_whole_millimetres_and_hidden_ones_are_none(squats):
    glimpses, _ = squats
    body = glimpses[-1].body
    joints = body.joints.copy()
    joints[list(glimpses[-1].skeleton.names).index("LeftHand")] = np.nan
    hidden = msgspec.structs.replace(glimpses[-1], body=msgspec.structs.replace(body, joints=joints))
    points = state_of(hidden, Judge(), 0.0)["points"]
    assert points.count(None) >= 1
    assert all(isinstance(value, int) for point in points if point for value in point)
    json.dumps(points, allow_nan=False)


# When it is shown.


@pytest.mark.parametrize(
    ("sources", "given", "wanted"),
    [
        (("webcam:",), {}, True),
        (("webcam:browser?model=lite",), {}, True),
        (("osc://0.0.0.0:39539",), {}, False),
        (("osc://0.0.0.0:39539",), {"segmentation": Segmenting(repetitions=True)}, True),
        (("zmq://127.0.0.1:5556",), {"streaming": Streaming(moves="m.json")}, True),
        (("-",), {"streaming": Streaming(moves="m.json", follow=("squat",))}, True),
        (("demo:",), {"segmentation": Segmenting(repetitions=True)}, False),
        (("walk.bvh",), {"streaming": Streaming(moves="m.json", follow=("squat",))}, False),
        (("demo:",), {"page": PageOptions(page="player")}, True),
        (("webcam:",), {"page": PageOptions(page="dashboard")}, False),
    ],
)
def test_cameras_and_senders_of_which_something_is_counted_have_the_page(sources, given, wanted):
    assert wants_player_page(run.Options(sources=sources, **given)) is wanted


def test_a_move_that_is_taught_on_the_page_of_a_camera_is_followed():
    def names(**streaming):
        return wanted_names(run.Options(sources=("webcam:",), streaming=Streaming(**streaming)))

    assert names() == ("all",)
    assert names(moves="m.json") == ()
    assert names(moves="m.json", follow=("squat",)) == ("squat",)


def test_the_camera_of_the_browser_needs_its_page(mossar):
    status, _, err = mossar("run", "webcam:browser")
    assert status == 2
    assert "mossar view webcam:browser" in err


def test_the_camera_of_the_browser_is_the_only_source(mossar):
    status, _, err = mossar("view", "webcam:browser", "demo:", "--no-browser", "--port", "0")
    assert status == 2
    assert "only source" in err


# The server.


class Told:
    """A page that remembers what it was asked for."""

    def __init__(self, **options):
        self.asked = []
        self.server = PlayerServer(0, **options)
        self.server.attach(self.asked.append, lambda: b"[]", None)


@pytest.fixture
def told():
    pytest.importorskip("websockets", reason="the extra web is not installed")
    page = Told()
    yield page
    page.server.close()


def get(server, path, **headers):
    request = urllib.request.Request(f"http://127.0.0.1:{server.port}{path}", headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=SOON) as answer:
            return answer.status, dict(answer.headers), answer.read()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), error.read()


def line_to(server, **options):
    from websockets.sync.client import connect

    return connect(f"ws://127.0.0.1:{server.port}{LINE}", open_timeout=SOON, **options)


def eventually(condition):
    end = time.monotonic() + SOON
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_the_page_and_its_files_are_served_and_nothing_else(told):
    for path, kind in {"/": "text/html", "/page.js": "text/javascript", "/colours.css": "text/css"}.items():
        status, headers, body = get(told.server, path)
        assert status == 200
        assert headers["Content-Type"].startswith(kind)
        assert len(body) > 100
    for path in ("/server.py", "/../server.py", "/%2e%2e/server.py", "/etc/passwd", "/full.task"):
        assert get(told.server, path)[0] == 404
    assert get(told.server, "/dashboard")[0] == 404


def test_the_page_may_connect_to_its_own_server_alone(told):
    policy = get(told.server, "/")[1]["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "connect-src 'self';" in policy
    assert "frame-ancestors 'none'" in policy


def test_names_of_other_sites_that_point_here_and_pages_of_other_sites_are_refused(told):
    own = f"http://127.0.0.1:{told.server.port}"
    assert get(told.server, "/", Host="evil.example:80")[0] == 403
    assert get(told.server, "/", Origin="http://evil.example")[0] == 403
    assert get(told.server, "/", Origin="http://localhost:1")[0] == 403
    assert get(told.server, "/", Origin=own)[0] == 200
    from websockets.exceptions import InvalidStatus

    for origin in ("http://evil.example", "null", "http://localhost:1"):
        with pytest.raises(InvalidStatus):
            line_to(told.server, origin=origin)
    with line_to(told.server, origin=own):
        eventually(lambda: told.server.windows == 1)
    eventually(lambda: told.server.windows == 0)


def test_a_window_asks_for_things_and_nonsense_is_ignored(told):
    with line_to(told.server) as line:
        for text in ("{}", "[", '{"do": 1}', '{"do": "teach", "path": "/etc/passwd"}', b"\xff"):
            line.send(text)
        line.send('{"do": "teach", "name": "squat"}')
        eventually(lambda: told.asked)
    assert told.asked == [Asked("teach", "squat")]


def test_a_window_gets_the_newest_state_when_it_asks(told):
    with line_to(told.server) as line:
        eventually(lambda: told.server.windows == 1)
        for number in range(5):
            told.server.spread(f"state {number}")
        line.send('{"do": "next"}')
        assert line.recv(SOON) == "state 4"
        told.server.spread("text", b"picture")
        line.send('{"do": "next"}')
        assert line.recv(SOON) == b"picture"


def test_a_window_that_floods_the_page_with_orders_delays_no_other_one(told):
    with line_to(told.server) as flood, line_to(told.server) as other:
        for _ in range(2000):
            flood.send('{"do": "keep"}')
        other.send('{"do": "teach", "name": "squat"}')
        eventually(lambda: Asked("teach", "squat") in told.asked)
        flood.send('{"do": "next"}')
        told.server.spread("state")
        assert flood.recv(SOON) == "state"  # the line itself goes on
        assert told.asked.count(Asked("keep")) < 500


def test_orders_of_a_window_that_are_left_out_come_back_with_time():
    window = Window(None, is_here=True)
    assert sum(window.may_order(5.0) for _ in range(100)) == 16
    assert not window.may_order(5.1)
    assert sum(window.may_order(6.1) for _ in range(100)) == 8
    assert sum(window.may_order(600.0) for _ in range(100)) == 16


def test_windows_that_ask_and_never_read_hold_nobody_up(told):
    with contextlib.ExitStack() as opened:
        for _ in range(20):
            lazy = opened.enter_context(socket.create_connection(("127.0.0.1", told.server.port), SOON))
            lazy.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            lazy.sendall(
                f"GET {LINE} HTTP/1.1\r\nHost: 127.0.0.1:{told.server.port}\r\nUpgrade: websocket\r\n".encode()
                + b"Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
            )
            lazy.sendall(b'\x81\x8e\0\0\0\0{"do": "next"}' * 50)
        eventually(lambda: told.server.windows == 20)
        with line_to(told.server) as line:
            for number in range(50):
                told.server.spread(f"{number} " + "x" * 100_000)
                line.send('{"do": "next"}')
                assert line.recv(SOON).startswith(f"{number} ")


def test_300_silent_connections_become_no_threads_and_the_page_still_answers(told):
    before = threading.active_count()
    with contextlib.ExitStack() as opened:
        for _ in range(300):
            silent = opened.enter_context(socket.create_connection(("127.0.0.1", told.server.port), SOON))
            silent.sendall(b"GET / HTTP/1.1\r\n")
        assert threading.active_count() <= before
        assert get(told.server, "/")[0] == 200


def test_the_next_port_is_taken_if_one_is_in_use(told):
    other = PlayerServer(told.server.port)
    try:
        assert other.port > told.server.port
    finally:
        other.close()
    with pytest.raises(MossarError, match="not an address of this computer"):
        PlayerServer(0, "203.0.113.7")


def test_other_devices_see_no_camera_and_no_picture(told, monkeypatch):
    told.server._eye = SimpleNamespace(
        line="ws://127.0.0.1:1", about={"model": "full"}, files={"/full.task": lambda: b"weights"}
    )
    assert json.loads(get(told.server, "/about.json")[2])["eye"] == {"model": "full"}
    assert get(told.server, "/full.task")[0] == 200
    monkeypatch.setattr("mossar_tools.player_page.server.is_loopback", lambda _: False)
    assert json.loads(get(told.server, "/about.json")[2])["eye"] is None
    assert get(told.server, "/full.task")[0] == 404
    with line_to(told.server) as line:
        eventually(lambda: told.server.windows == 1)
        line.send('{"do": "next"}')
        told.server.spread("text", b"picture")
        assert line.recv(SOON) == "text"


def test_the_url_for_another_device_serves_once(caplog):
    with caplog.at_level("INFO", "mossar"):
        page = Told(host="0.0.0.0")
        page.server.close()
    said = [message for message in caplog.messages if "lets in once" in message]
    assert len(said) == 1
    assert f":{page.server.port}/?key=" in said[0]


# The page as a whole.


class Shown:
    """A live show that tells what a page asked it for."""

    waits_for = "waiting for frames …"
    first_name = "squat"

    def __init__(self, tmp_path, glimpses=(), rate=25.0):
        self._live = LiveShow(Settings(), folder=tmp_path)
        self.teaching = self._live.teaching
        self.found, self.rate, self.calls = list(glimpses), rate, []

    def glimpses(self):
        return self.found

    def rate_of(self, _):
        return self.rate

    def teach(self, name):
        self.calls.append(("teach", name))
        if name == "bad":
            raise MossarError("a move cannot be called so")

    def count_again(self):
        self.calls.append("again")


@pytest.fixture
def clock(monkeypatch):
    class Clock:
        now = 100.0

        def monotonic(self):
            return self.now

    ticking = Clock()
    monkeypatch.setattr(page_module, "time", ticking)
    return ticking


def last_state(told, page):
    """Return what a window is shown after a round."""
    with line_to(told.server) as line:
        eventually(lambda: told.server.windows == 1)
        page._draw(0)
        line.send('{"do": "next"}')
        found = line.recv(SOON)
    eventually(lambda: told.server.windows == 0)
    return found


def test_slow_pictures_come_with_the_hint_to_try_lite(told, tmp_path, squats, clock):
    show = Shown(tmp_path, [squats[0][-1]], rate=4.0)
    page = PlayerPage(told.server, show, model="full")
    assert json.loads(last_state(told, page))["note"] == ""
    clock.now += 1.0
    show.found = [squats[0][-2]]
    last_state(told, page)
    clock.now += 3.0
    show.found = [squats[0][-1]]
    assert "only 4 pictures a second: the model lite" in json.loads(last_state(told, page))["note"]
    for rate, warned in ((6.0, True), (30.0, True), (30.0, False)):  # it can be read, and does not flicker
        show.rate = rate
        clock.now += 0.5 if warned else 10.0
        show.found = [squats[0][-2 if warned else -1]]
        assert ("only 4 pictures" in json.loads(last_state(told, page))["note"]) == warned
    show.rate = 4.0
    lite = PlayerPage(told.server, show, model="lite")
    last_state(told, lite)
    clock.now += 10.0
    show.found = [squats[0][-2]]
    assert json.loads(last_state(told, lite))["note"] == ""


def test_the_page_says_when_no_frames_come_and_why(told, tmp_path, squats, clock):
    show = Shown(tmp_path)
    page = PlayerPage(told.server, show)
    assert json.loads(last_state(told, page))["note"] == "waiting for frames …"
    show.found = [squats[0][-1]]
    assert json.loads(last_state(told, page))["note"] == ""
    clock.now += 5.0
    shown = json.loads(last_state(told, page))
    assert shown["note"] == "no frames come"
    assert shown["performers"][0]["stale"]
    assert shown["performers"][0]["seconds"] == 5


def test_a_camera_that_stops_is_told_from_a_player_who_left(told, tmp_path, squats, clock):
    pytest.importorskip("cv2", reason="the extra webcam is not installed")
    from mossar_adapters.pose.source import Seen

    pictures = [Seen(np.zeros((36, 64, 3), np.uint8), ()) for _ in range(2)]
    show = Shown(tmp_path, [squats[0][-1]])
    page = PlayerPage(told.server, show, preview=lambda: pictures[0], model="full")

    def note():
        message = last_state(told, page)
        (length,) = struct.unpack_from("<I", message)
        return json.loads(message[4 : 4 + length])["note"]

    assert note() == ""
    clock.now += 5.0
    assert note() == "the camera gives no more pictures"
    pictures.pop(0)
    assert note() == "step back until the whole body is in the picture"


def test_what_a_window_asks_for_is_done_in_order_and_failures_are_shown(told, tmp_path, squats):
    show = Shown(tmp_path, [squats[0][-1]])
    page = PlayerPage(told.server, show)
    with line_to(told.server) as line:
        for text in (
            '{"do": "teach", "name": " squat "}',
            '{"do": "again"}',
            '{"do": "teach", "name": "bad"}',
        ):
            line.send(text)
        eventually(lambda: len(show.calls) == 3)
    assert show.calls == [("teach", "squat"), "again", ("teach", "bad")]
    eventually(lambda: json.loads(last_state(told, page))["note"] == "a move cannot be called so")
    page.close()


def test_a_picture_comes_with_the_people_who_were_found_in_it(told, tmp_path, squats):
    pytest.importorskip("cv2", reason="the extra webcam is not installed")
    from mossar_adapters.pose.source import Seen

    pixels = np.full((33, 2), 400.0, np.float32)
    pixels[BLAZEPOSE_33.index("left_knee")] = (480, 270)
    confidence = np.full(33, 0.9, np.float32)
    confidence[BLAZEPOSE_33.index("right_knee")] = 0.2
    body = Body(1, np.zeros((33, 3), np.float32), confidence, pixels)
    seen = Seen(np.zeros((540, 960, 3), np.uint8), (body,))
    page = PlayerPage(told.server, Shown(tmp_path, [squats[0][-1]]), preview=lambda: seen)
    message = last_state(told, page)
    (length,) = struct.unpack_from("<I", message)
    state, picture = json.loads(message[4 : 4 + length]), message[4 + length :]
    assert picture.startswith(b"\xff\xd8\xff")
    points = dict(zip(outline_of(SKELETON).joints, state["people"][0], strict=True))
    assert points["left_knee"] == [0.5, 0.5]
    assert points["right_knee"] is None
    assert state["outline"]["bones"]


def test_large_pictures_are_made_smaller():
    cv2 = pytest.importorskip("cv2", reason="the extra webcam is not installed")
    from mossar_adapters.pose.source import Seen
    from mossar_tools.player_page.pictures import WIDTH, jpeg_of

    jpeg = jpeg_of(Seen(np.zeros((1080, 1920, 3), np.uint8), ()))
    assert cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR).shape == (WIDTH * 9 // 16, WIDTH, 3)


def test_examples_are_listed_with_what_forgets_them(told, tmp_path, moves):
    show = Shown(tmp_path)
    show.teaching.moves = moves
    page = PlayerPage(told.server, show)
    (example,) = json.loads(get(told.server, "/examples.json")[2])
    assert (example["name"], example["place"]) == ("squat", 0)
    assert example["seconds"] == pytest.approx(1.2, abs=0.1)
    assert example["drawing"].startswith("<svg")
    before = json.loads(last_state(told, page))["teaching"]["version"]
    show.teaching.moves = Moves(moves.skeleton)
    assert json.loads(last_state(told, page))["teaching"]["version"] != before
