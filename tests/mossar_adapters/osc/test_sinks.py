import socket

import msgspec
import numpy as np
import pytest
from pythonosc.osc_message import OscMessage

from mossar_adapters.address import parse_url
from mossar_adapters.demo import DemoSource
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.joint_sets import COCO_17
from mossar_adapters.osc.frame_sink import OscFrameSink
from mossar_adapters.osc.source import OscSource
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_sink
from mossar_stream import (
    ActivityEvent,
    FollowEvent,
    Frames,
    KeyFrameEvent,
    MossarError,
    MoveEvent,
    PhaseEvent,
    PoseEvent,
    RepetitionEvent,
    Skeleton,
    StreamEvent,
)


def replay(hear, profile, source_query, items, **options):
    """Send items to a source and return what arrives."""
    source = OscSource(parse_url(f"osc://127.0.0.1:0?{source_query}"), ReadOptions(**options))
    sink = OscFrameSink(parse_url(f"osc://127.0.0.1:{source.port}?profile={profile}"))

    def send():
        for item in items:
            if isinstance(item, Meta):
                sink.announce(item)
            else:
                sink.send_frames(item)

    heard = hear(source, send)
    sink.close()
    assert source.counters.malformed == source.counters.ignored == 0
    return heard


def test_the_phase_of_a_movement_goes_out_frame_by_frame():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(5)
        sink = open_sink(f"osc://127.0.0.1:{receiver.getsockname()[1]}")
        said = {"performer": "p1", "take": 2, "channel": "body", "time": 1.0}
        sink.send([PhaseEvent(**said, phase=0.25), PhaseEvent(**said, phase=None)])
        messages = [OscMessage(receiver.recv(1000)) for _ in range(2)]
        sink.close()
    assert [m.address for m in messages] == ["/mossar/phase"] * 2
    assert [m.params for m in messages] == [["p1", "body", 2, 0.25], ["p1", "body", 2, -1.0]]


def test_a_repetition_can_be_told_from_others_and_a_run_too(made):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(5)
        sink = open_sink(f"osc://127.0.0.1:{receiver.getsockname()[1]}")
        sink.send([StreamEvent(performer="p1", event="started", take=0, run="a1")])
        sink.send([made(RepetitionEvent, rev=3, total=4)])
        datagrams = [receiver.recv(1000) for _ in range(3)]
        sink.close()
    run, _, counted = map(OscMessage, datagrams)
    assert (run.address, run.params) == ("/mossar/run", ["p1", "a1"])
    assert b",sssiiiffsi" in datagrams[2]
    assert counted.params == ["p1", "counted", "body", 0, 2, 4, 2.0, 30.0, "p1/0/r2", 3]


def test_a_followed_move_says_how_far_it_is_and_how_much_each_limb_strays(made):
    event = made(FollowEvent, rev=2)
    last = {"status": "done", "count": 3, "progress": 1.0, "range": {"left_leg": 0.5}, "score": 0.25}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(5)
        sink = open_sink(f"osc://127.0.0.1:{receiver.getsockname()[1]}")
        sink.begin_take("p1", 0, 10.0)
        sink.send([event, msgspec.structs.replace(event, **last)])
        datagrams = [receiver.recv(1000) for _ in range(2)]
        sink.close()
    assert all(b",sssssiiffffffffsisffsff" in datagram for datagram in datagrams)
    going, done = map(OscMessage, datagrams)
    assert going.address == "/mossar/follow"
    assert going.params[:7] == ["p1", "progress", "squat", "left_leg", "LeftKnee", 0, 2]
    assert going.params[7:17] == [0.5, 1.25, 0.75, 8.0, -1.0, 2.0, 3.0, 3.5, "p1/follow/0/3", 2]
    assert going.params[17:] == ["trunk", 5.0, -1.0, "left_leg", 12.0, -1.0]
    assert (done.params[1], done.params[6], done.params[7], done.params[11]) == ("done", 3, 1.0, 0.25)
    assert done.params[17:] == ["trunk", 5.0, -1.0, "left_leg", 12.0, 0.5]


def test_a_held_pose_says_how_long_and_where_the_body_strays(made):
    event = made(PoseEvent, rev=2)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(5)
        sink = open_sink(f"osc://127.0.0.1:{receiver.getsockname()[1]}")
        sink.begin_take("p1", 0, 10.0)
        sink.send([event])
        datagram = receiver.recv(1000)
        sink.close()
    assert b",sssssiffffsisfsf" in datagram
    message = OscMessage(datagram)
    assert message.address == "/mossar/pose"
    assert message.params[:6] == ["p1", "held", "plank", "left_leg", "LeftKnee", 0]
    assert message.params[6:12] == [2.0, 1.5, 8.0, 3.5, "p1/pose/0/2", 2]
    assert message.params[12:] == ["trunk", 5.0, "left_leg", 12.0]


def test_limbs_have_addresses_of_their_own_with_the_channel_after_the_performer_and_moves_theirs(told):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(5)
        sink = open_sink(f"osc://127.0.0.1:{receiver.getsockname()[1]}")
        for event in told:  # one by one, so that the buffer of the socket is enough
            sink.send([event])
            message = OscMessage(receiver.recv(4000))
            kind = str(event.__struct_config__.tag)
            channel = getattr(event, "channel", "body")
            if isinstance(event, ActivityEvent):
                assert message.address == "/mossar/activity"
                assert message.params[:4] == ["p1", channel, event.state, event.take]
                previous = -1.0 if event.previous is None else event.previous
                decided = message.params[5] - message.params[4]
                assert decided == pytest.approx(event.decided_time - event.start, abs=1e-5)
                assert message.params[6] == pytest.approx(previous, abs=1e-5)
                continue
            who = ["p1"] if channel == "body" else ["p1", channel]
            assert message.address == (f"/mossar/{kind}" if channel == "body" else f"/mossar/limb/{kind}")
            assert message.params[: len(who)] == who
            if isinstance(event, KeyFrameEvent):
                own = [event.status, event.kind, event.take, event.frame]
                assert message.params[len(who) : len(who) + 4] == own
            elif isinstance(event, MoveEvent):
                assert message.params[1:4] == [event.status, event.name, event.limb]
        sink.close()


@pytest.fixture(scope="module")
def demo():
    return list(DemoSource.from_url("demo:?seconds=1&seed=5", speed="max").items())


@pytest.mark.parametrize(
    ("profile", "source_query"),
    [
        ("mossar", "profile=auto"),
        ("osceleton", "profile=auto"),
        ("kinectv2", "profile=auto"),
        ("nimate", "profile=auto"),
        ("flat", "profile=flat"),
        (
            "generic&pattern=/p/{performer}/{joint}&args=_zyx",
            "profile=generic&pattern=/p/{performer}/{joint}&args=_zyx",
        ),
        ("generic&pattern=/all&args=pjcxyz", "profile=generic&pattern=/all&args=pjcxyz"),
    ],
)
def test_what_every_profile_sends_its_source_reads(hear, demo, profile, source_query):
    heard = replay(hear, profile, source_query, demo, unit="m", fps=60.0)
    sent = np.concatenate([item.positions for item in demo[1:]])
    assert heard.positions() == pytest.approx(sent, abs=2e-6)
    assert heard.times() == pytest.approx(np.arange(60) / 60)
    if profile != "flat":
        assert heard.metas[0].skeleton.names == demo[0].skeleton.names


def test_the_bodys_centre_survives_where_names_do_not_tell_it(hear):
    for root in (1, -1):
        skeleton = Skeleton(("alpha", "beta"), (-1, 0), root)
        frames = Frames(np.ones((3, 2, 3), np.float32), np.arange(3) / 60)
        heard = replay(hear, "mossar", "", [Meta("p1", skeleton), frames])
        assert heard.metas[0].skeleton.root == root


def test_confidence_travels_with_flat_arrays(hear):
    positions = np.random.default_rng(2).uniform(0, 1.7, (4, 17, 3)).astype(np.float32)
    frames = Frames(positions, np.arange(4) / 30, np.full((4, 17), 0.25, np.float32))
    heard = replay(hear, "flat", "", [Meta("p1", COCO_17), frames], unit="m")
    assert np.concatenate([f.confidence for f in heard.frames()]) == pytest.approx(np.full((4, 17), 0.25))
    assert heard.metas[0].skeleton == COCO_17


@pytest.mark.parametrize("profile", ["mossar", "osceleton"])
def test_ten_performers_interleaved_are_ten_separate_streams(hear, profile):
    url = "demo:?seconds=1&performers=10&noise=0.005"
    items = list(DemoSource.from_url(url, speed="max").items())
    heard = replay(hear, profile, "profile=auto", items, unit="m", fps=60.0)
    assert heard.performers() == sorted(f"p{k}" for k in range(1, 11))
    for k in range(1, 11):
        alone = [item for item in items if isinstance(item, Frames) and item.performer == f"p{k}"]
        sent = np.concatenate([item.positions for item in alone])
        assert heard.positions(f"p{k}") == pytest.approx(sent, abs=2e-6)
        assert heard.times(f"p{k}") == pytest.approx(np.concatenate([item.times for item in alone]))


def test_vmc_refuses_joints_that_are_no_humanoid():
    from mossar_adapters.osc.frame_sink import open_osc_frame_sink

    sink = open_osc_frame_sink(parse_url("osc://127.0.0.1:9?profile=vmc"))
    with pytest.raises(MossarError, match="humanoid"):
        sink.announce(Meta("p1", Skeleton(("a", "b"))))
    sink.close()


def test_sending_to_nobody_does_no_harm(demo):
    sink = OscFrameSink(parse_url("osc://127.0.0.1:9"))
    for _ in range(3):
        sink.announce(demo[0])
        sink.send_frames(demo[1])
    sink.close()
    sink.close()
