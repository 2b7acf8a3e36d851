"""Measure what `mossar run` keeps up with, and how long it takes from a frame to its event.

`python -m mossar_tools.load osc` sends 600 frames/s of 33 single-joint messages for 30 s, `… zmq` 2000 frames/s; what
got lost is printed. With `--delay` a performer moves at 60 frames/s, and this program, the client outside, takes the
time from sending a frame until it has received the event that this frame caused.
"""

import argparse
import contextlib
import socket
import time
from collections.abc import Callable, Iterator
from typing import Protocol

import msgspec
import numpy as np
import zmq
from pythonosc.osc_packet import OscPacket

from mossar_adapters.address import parse_url
from mossar_adapters.demo import DemoSource
from mossar_adapters.interleaving import part
from mossar_adapters.osc.encode import encode
from mossar_adapters.sink import FrameSink
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_frame_sink
from mossar_adapters.zeromq.sink import ZmqFrameSink
from mossar_stream.events import KeyFrameEvent
from mossar_stream.frames import Frames
from mossar_stream.skeleton import Skeleton
from mossar_tools.outside import OutsideRun, free_port

RATES = {"osc": 600.0, "zmq": 2000.0}  # frames/s
LOSSES = ("gaps", "malformed", "kernel_drops", "queue_dropped", "out_of_order")
_LAST = 1.0  # s to wait for the last events
_DECIDED = 6  # place of the time among the arguments of /mossar/key_frame


def main() -> None:
    """Send, receive, print one line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("transport", choices=list(RATES))
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--fps", type=float, help="frames per second (default: 600 for osc, 2000 for zmq)")
    parser.add_argument(
        "--joints", type=int, default=33, help="joints of a frame; over osc each is a message"
    )
    parser.add_argument("--delay", action="store_true", help="measure delays, at 60 frames/s")
    given = parser.parse_args()
    if given.delay:
        print(delay(given.transport, given.seconds))
    else:
        fps = given.fps or RATES[given.transport]
        print(load(given.transport, round(given.seconds * fps), fps, given.joints))


def load(transport: str, frames: int, fps: float, joints: int) -> str:
    """Send frames at a steady pace to `mossar run`, and say what it got.

    Args:
        transport: `osc` or `zmq`.
        frames: How many.
        fps: Per second.
        joints: Of each frame.
    """
    port = free_port(socket.SOCK_DGRAM if transport == "osc" else socket.SOCK_STREAM)
    url = f"osc://127.0.0.1:{port}?profile=generic&pattern=/pose/{{joint}}&unit=m"
    with contextlib.ExitStack() as opened:
        send = (
            _single_joints(port, joints, opened)
            if transport == "osc"
            else _frame_maps(port, joints, fps, opened)
        )
        run = opened.enter_context(
            OutsideRun(url if transport == "osc" else f"zmq+bind://127.0.0.1:{port}", "-")
        )
        late = 0.0
        started = time.monotonic()
        for k in range(frames):
            due = started + k / fps
            time.sleep(max(0.0, due - time.monotonic()))
            late = max(late, time.monotonic() - due)
            send(k)
        seconds = time.monotonic() - started
        stats = run.settled_stats().get("p1", {})
    lost = (
        ", ".join(f"{stats[name]} {name.replace('_', ' ')}" for name in LOSSES if stats.get(name))
        or "nothing lost"
    )
    return (
        f"{transport}: {frames} frames of {joints} joints sent in {seconds:.2f} s ({frames / seconds:.0f} per second, at "
        f"most {late * 1000:.0f} ms late), {stats.get('frames', 0)} segmented; {lost}"
    )


def _single_joints(port: int, joints: int, opened: contextlib.ExitStack) -> Callable[[int], None]:
    wire = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))

    def send(number: int) -> None:
        for joint in range(joints):
            data = encode(f"/pose/joint{joint}", "fff", 0.1 * joint, 1.0, float(np.sin(number / 600)))
            wire.sendto(data, ("127.0.0.1", port))

    return send


def _frame_maps(port: int, joints: int, fps: float, opened: contextlib.ExitStack) -> Callable[[int], None]:
    sink = ZmqFrameSink(parse_url(f"zmq://127.0.0.1:{port}?wait=120"))
    opened.callback(sink.close)
    sink.announce(Meta("p1", Skeleton(tuple(f"joint{i}" for i in range(joints)))))
    positions = np.zeros((1, joints, 3), np.float32)

    def send(number: int) -> None:
        positions[0, :, 0] = np.sin(number / 600)
        sink.send_frames(Frames(positions, np.array([number / fps])))

    return send


class Delays(msgspec.Struct, frozen=True):
    """How long events took.

    Args:
        frames: Sent, and segmented.
        seconds: From sending a frame to receiving the message that it caused, for each message.
        inside_p50: ms, median of the delay inside `mossar run`.
        inside_p99: ms.
    """

    frames: int
    seconds: list[float]
    inside_p50: float
    inside_p99: float


def delays(transport: str, seconds: float) -> Delays:
    """Let a performer move at 60 frames/s before `mossar run`, and return how long its events took.

    Args:
        transport: `osc` or `zmq`, for the way in and the way out.
        seconds: Of the performance.
    """
    osc = transport == "osc"
    kind = socket.SOCK_DGRAM if osc else socket.SOCK_STREAM
    into, out = (f"{'osc' if osc else 'zmq+bind'}://127.0.0.1:{free_port(kind)}" for _ in range(2))
    with contextlib.ExitStack() as opened:
        client: _Client = _OscClient(out, opened) if osc else _ZmqClient(out, opened)
        run = opened.enter_context(OutsideRun(into, out, "--emit", "key_frame"))
        sink = open_frame_sink(into if osc else into.replace("+bind", "") + "?wait=120")
        opened.callback(sink.close)
        found = list(_timed(sink, client, DemoSource(seconds=seconds, speed="max")))
        stats = run.settled_stats()["p1"]
    return Delays(stats["frames"], found, stats["latency_p50_ms"], stats["latency_p99_ms"])


def delay(transport: str, seconds: float) -> str:
    """Return in words what `delays` finds."""
    found = delays(transport, seconds)
    taken = np.array(found.seconds) * 1000
    median, high = np.quantile(taken, (0.5, 0.99))
    return (
        f"{transport}: {found.frames} frames at 60 per second, {len(taken)} key-frame messages; from sending a frame "
        f"to receiving its message: median {median:.2f} ms, 99 % {high:.2f} ms, longest {taken.max():.2f} ms "
        f"(of these inside mossar run: median {found.inside_p50:.2f} ms, 99 % {found.inside_p99:.2f} ms)"
    )


class _Client(Protocol):
    """Somebody outside who waits for key frames."""

    def receive(self, seconds: float) -> list[float]:
        """Return the times of the frames that caused the messages which come within `seconds`; s of the take."""


class _OscClient:
    def __init__(self, url: str, opened: contextlib.ExitStack) -> None:
        self._socket = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        self._socket.bind(("127.0.0.1", parse_url(url).required_port()))

    def receive(self, seconds: float) -> list[float]:
        self._socket.settimeout(max(seconds, 1e-4))
        try:
            data = self._socket.recv(65535)
        except TimeoutError:
            return []
        messages = [timed.message for timed in OscPacket(data).messages]
        return [m.params[_DECIDED] for m in messages if m.address == "/mossar/key_frame"]


class _ZmqClient:
    def __init__(self, url: str, opened: contextlib.ExitStack) -> None:
        self._socket: zmq.Socket[bytes] = opened.enter_context(zmq.Context.instance().socket(zmq.SUB))
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.SUBSCRIBE, b"mossar.key_frame.")
        self._socket.connect(url.replace("zmq+bind", "tcp"))

    def receive(self, seconds: float) -> list[float]:
        # Polling counts whole milliseconds; less than one is waited for by looking again and again.
        if not self._socket.poll(int(seconds * 1000)):
            return []
        found: KeyFrameEvent = msgspec.msgpack.decode(self._socket.recv_multipart()[1], type=KeyFrameEvent)
        return [found.decided_time]


def _timed(sink: FrameSink, client: "_Client", source: DemoSource) -> Iterator[float]:
    """Send a performance and yield the delay of each message, s, in the time between two frames."""
    sent: dict[int, float] = {}  # monotonic s at which each frame left
    fps = 0.0
    began = time.monotonic()
    for item in source.items():
        if isinstance(item, Meta):
            fps = item.fps or fps
            sink.announce(item)
            continue
        if item is None:
            continue
        for i in range(len(item)):
            number = len(sent)
            yield from _received(client, sent, fps, began + number / fps)
            sent[number] = time.monotonic()
            sink.send_frames(part(item, i, i + 1))
    yield from _received(client, sent, fps, time.monotonic() + _LAST)


def _received(client: "_Client", sent: dict[int, float], fps: float, until: float) -> Iterator[float]:
    while (left := until - time.monotonic()) > 0:
        for decided in client.receive(left):
            yield time.monotonic() - sent[round(decided * fps)]


if __name__ == "__main__":
    main()
