"""Programs that we did not write, on the other end of the wire."""

import json
import re
import socket
import subprocess
import time

import msgspec
import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.osc.event_sink import OscSink
from mossar_adapters.osc.source import OscSource
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_sink
from mossar_adapters.zeromq.source import ZmqSource
from mossar_stream import KeyFrameEvent, SegmentEvent, Skeleton, StreamEvent

META = Meta("p1", Skeleton(("hips", "head"), (-1, 0)), 60.0)
KEY_FRAME = KeyFrameEvent(
    performer="p1",
    id="p1/2/30",
    rev=3,
    status="merged",
    decided=True,
    kind="minimum",
    take=2,
    frame=30,
    time=100.5,
    decided_frame=60,
    decided_time=101.0,
    velocity=0.25,
    strength=None,
)
SEGMENT = SegmentEvent(
    performer="p1",
    id="p1/2/0-30",
    rev=1,
    status="final",
    state="resting",
    take=2,
    start_frame=0,
    end_frame=30,
    start_time=100.0,
    end_time=100.5,
    active_joints=("head",),
    similarity=None,
)
STREAM = StreamEvent(performer="p1", event="ended", take=2, reason="file ended")


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def lines_of(running, count):
    return [running.stdout.readline().strip() for _ in range(count)]


@pytest.fixture
def ended():
    """End the programs that a test started, whatever happened."""
    started = []
    yield started.append
    for running in started:
        running.terminate()
        running.wait(5)
        running.stdout.close()


def test_oscsend_drives_the_source(hear, program):
    oscsend = program("oscsend", "liblo-tools")
    source = OscSource(parse_url("osc://127.0.0.1:0"))

    def send():
        for k in range(6):
            for i, name in enumerate(("head", "neck", "torso")):
                arguments = ["/joint", "sifff", name, "1", "0.5", str(0.1 * i), str(2 + 0.1 * k)]
                subprocess.run([oscsend, "127.0.0.1", str(source.port), *arguments], check=True)

    heard = hear(source, send)
    assert heard.performers() == ["p1"], "every call has a port of its own and is still the same sender"
    # A process per joint on a busy machine may pause so long that a frame counts as two.
    assert 6 <= heard.count() <= 8
    assert sum(np.isfinite(item.positions[:, :, 0]).sum() for item in heard.frames()) == 18


def test_oscsendfile_replays_a_log_into_the_source(hear, program, tmp_path):
    oscsendfile = program("oscsendfile", "liblo-tools")
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    log = tmp_path / "take.osc"
    names = ("head", "neck", "torso")
    log.write_text(
        "".join(
            f'{0xE0000000 + k // 50:08x}.{(k % 50) * 85899345:08x} /joint sifff "{name}" 1 0.5 0.{i} 2.{k:02d}\n'
            for k in range(20)
            for i, name in enumerate(names)
        )
    )
    command = [oscsendfile, f"osc.udp://127.0.0.1:{source.port}", str(log)]
    heard = hear(source, lambda: subprocess.run(command, check=True, timeout=20, stdout=subprocess.DEVNULL))
    assert heard.count() == 20
    assert np.isfinite(heard.positions()).all()
    assert (np.diff(heard.times()) > 0).all()
    assert np.ptp(heard.times()) > 0.25, "the log's timing, whatever a busy machine adds to it"


def test_oscdump_prints_the_events(program, ended):
    oscdump = program("oscdump", "liblo-tools")
    port = free_udp_port()
    running = subprocess.Popen([oscdump, "-L", str(port)], stdout=subprocess.PIPE, text=True)
    ended(running)
    time.sleep(0.3)
    sink = OscSink(parse_url(f"osc://127.0.0.1:{port}"))
    sink.begin_take("p1", 2, 100.0)
    sink.send([KEY_FRAME, SEGMENT, STREAM])
    sink.close()
    printed = [re.sub(r"^\S+ ", "", line) for line in lines_of(running, 3)]
    assert printed == [
        '/mossar/key_frame sssiiffffi "p1" "merged" "minimum" 2 30 0.500000 1.000000 0.250000 -1.000000 3',
        '/mossar/segment sssiiiff "p1" "final" "resting" 2 0 30 0.000000 0.500000',
        '/mossar/stream sssi "p1" "ended" "file ended" 2',
    ]


def test_npm_osc_sends_vmc_as_the_reference_sender_does(hear, node):
    source = OscSource(parse_url("osc://127.0.0.1:0"))

    def send():
        running = node("vmc_sender.js", source.port, 30, 60)
        output, _ = running.communicate(timeout=20)
        assert (running.returncode, output) == (0, "")

    heard = hear(source, send)
    assert heard.count() == 30
    assert len(heard.metas[0].skeleton) == 22
    assert np.isfinite(heard.positions()).all()
    assert np.array_equal(heard.times(), np.arange(30) / 60)
    hips = heard.metas[0].skeleton.index("Hips")
    assert heard.positions()[:, hips, 2] == pytest.approx(0.001 * np.arange(30), abs=1e-6)


def test_npm_node_osc_sends_whole_numbers_as_integers(hear, node):
    source = OscSource(parse_url("osc://127.0.0.1:0"), ReadOptions(unit="m"))

    def send():
        running = node("osc_client.js", source.port, 10)
        output, _ = running.communicate(timeout=20)
        assert (running.returncode, output) == (0, "")

    heard = hear(source, send)
    assert heard.count() == 10
    assert source.counters.malformed == 0


def test_npm_node_osc_receives_the_events(node, ended):
    port = free_udp_port()
    running = node("osc_server.js", port, 3)
    ended(running)
    assert lines_of(running, 1) == ["ready"]
    sink = OscSink(parse_url(f"osc://127.0.0.1:{port}"))
    sink.send([SEGMENT, KEY_FRAME, STREAM])
    sink.close()
    segment, key_frame, stream = map(json.loads, lines_of(running, 3))
    assert segment == ["/mossar/segment", "p1", "final", "resting", 2, 0, 30, 0, 0.5]
    assert key_frame == ["/mossar/key_frame", "p1", "merged", "minimum", 2, 30, 0.5, 1, 0.25, -1, 3]
    assert stream == ["/mossar/stream", "p1", "ended", "file ended", 2]


def test_npm_zeromq_subscribes(node, ended):
    sink = open_sink("zmq+bind://127.0.0.1:0?encoding=json")
    sink.announce(META)
    running = node("zmq_subscriber.js", sink.endpoint, "mossar.", 3)
    ended(running)
    assert lines_of(running, 1) == ["ready"]
    time.sleep(0.5)
    sink.send([KEY_FRAME, STREAM])
    lines = [line.partition(" ") for line in lines_of(running, 3)]
    sink.close()
    assert [topic for topic, _, _ in lines] == [
        "mossar.meta.p1.",
        "mossar.key_frame.p1.",
        "mossar.stream.p1.",
    ]
    assert json.loads(lines[0][2])["names"] == ["hips", "head"]
    assert json.loads(lines[1][2]) == msgspec.to_builtins(KEY_FRAME)


def test_npm_zeromq_publishes(hear, node):
    source = ZmqSource(parse_url("zmq+bind://127.0.0.1:0"))

    def send():
        running = node("zmq_publisher.js", source.endpoint, 50)
        output, _ = running.communicate(timeout=20)
        assert (running.returncode, output) == (0, "")

    heard = hear(source, send)
    assert heard.count("js") == 50
    assert source.counters.gaps == source.counters.malformed == 0


def test_npm_ws_receives_the_events(node, ended):
    sink = open_sink("ws://127.0.0.1:0")
    sink.announce(META)
    running = node("ws_client.js", f"ws://127.0.0.1:{sink.port}", 3)
    ended(running)
    assert lines_of(running, 1) == ["ready"]
    until = time.monotonic() + 30
    while not sink.clients and time.monotonic() < until:
        time.sleep(0.01)
    sink.send([KEY_FRAME, STREAM])
    meta, key_frame, stream = map(json.loads, lines_of(running, 3))
    sink.close()
    assert meta["type"] == "meta"
    assert key_frame == msgspec.to_builtins(KEY_FRAME)
    assert stream["event"] == "ended"
