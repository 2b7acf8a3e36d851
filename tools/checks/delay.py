"""Time from a frame to its event, and the share of it that any program would take.

A performer moves at 60 frames/s before a `mossar run`. The client outside takes the time from just before it sends a
frame until it has received the message that this frame caused. Half a frame later it sends the same frame to a plain
echo (`checks.echo`) and takes the time of that, too: the floor of the machine at this very moment. `mossar run`
adds the difference.
"""

import contextlib
import socket
import subprocess
import sys
import time
from typing import NamedTuple, Protocol

import msgspec
import numpy as np
import zmq
from pythonosc.osc_packet import OscPacket

from checks.run_process import RunProcess, free_port
from mossar_adapters.demo import DemoSource
from mossar_adapters.maps.codec import from_msgpack
from mossar_adapters.maps.frame_maps import FrameMap
from mossar_adapters.replay.interleaving import part
from mossar_adapters.sink import FrameSink
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_frame_sink
from mossar_stream import Frames, KeyFrameEvent

QUANTILES = (0.5, 0.99, 1.0)
_LAST = 0.5  # s to wait for the last events; after a second the take ends by the wall clock
_TIMES = {"/mossar/key_frame": 6, "/mossar/frame": 2}  # place of the frame's time among a message's arguments
_KEY_FRAME = b"mossar.key_frame."
_START = 20.0  # s that the echo may take to start


class Delays(msgspec.Struct, frozen=True):
    """Delays of messages, from just before a frame was sent to just after its message was received.

    Args:
        frames: Sent, and segmented.
        through: s, of each message that came through `mossar run`.
        echoed: s, of each frame that the echo sent back.
        inside_p50: ms, median of the delay inside `mossar run`.
        inside_p99: ms.
    """

    frames: int
    through: list[float]
    echoed: list[float]
    inside_p50: float
    inside_p99: float

    def quantiles_ms(self) -> tuple[list[float], list[float]]:
        """Return median, 99th percentile and longest through `mossar run`, and of the echo."""
        through, echoed = (
            [float(value) * 1000 for value in np.quantile(found, QUANTILES)]
            for found in (self.through, self.echoed)
        )
        return through, echoed


def delays(transport: str, seconds: float) -> Delays:
    """Stream a moving performer, and return the delays of its events.

    Args:
        transport: `osc` or `zmq`, for the way in and the way out.
        seconds: Of the performance.
    """
    osc = transport == "osc"
    kind = socket.SOCK_DGRAM if osc else socket.SOCK_STREAM
    into, out, into_echo, out_echo = (free_port(kind) for _ in range(4))
    with contextlib.ExitStack() as opened:
        client: _Client = _OscClient(out, opened) if osc else _ZmqClient((out, out_echo), opened)
        command = [sys.executable, "-m", "checks.echo", transport]
        echo = subprocess.Popen([*command, str(into_echo), str(out if osc else out_echo)])  # noqa: S603
        opened.callback(echo.wait)
        opened.callback(echo.terminate)
        scheme = "osc" if osc else "zmq+bind"
        urls = f"{scheme}://127.0.0.1:{into}", f"{scheme}://127.0.0.1:{out}"
        run = opened.enter_context(RunProcess(*urls, "--emit", "key_frame"))
        sinks = [open_frame_sink(f"{transport}://127.0.0.1:{port}") for port in (into, into_echo)]
        for sink in sinks:
            opened.callback(sink.close)
        stage = _Stage(client, *sinks)
        stage.perform(DemoSource(seconds=seconds, speed="max"))
        stats = run.settled_stats()["p1"]
    inside = stats["latency_p50_ms"], stats["latency_p99_ms"]
    return Delays(stats["frames"], stage.taken[False], stage.taken[True], *inside)


def in_words(transport: str, found: Delays) -> str:
    """Return delays in some lines."""
    through, echoed = found.quantiles_ms()
    return "\n".join(
        [
            f"{transport}: {found.frames} frames at 60 per second, {len(found.through)} key-frame messages",
            "from sending a frame to receiving its message",
            f"  through mossar run   {_figures(through)}",
            f"  a plain echo         {_figures(echoed)}",
            f"  added                median {through[0] - echoed[0]:.2f} ms, 99 % {through[1] - echoed[1]:.2f} ms",
            f"  inside mossar run    median {found.inside_p50:.2f} ms, 99 % {found.inside_p99:.2f} ms",
        ]
    )


def _figures(ms: list[float]) -> str:
    return "median {:.2f} ms, 99 % {:.2f} ms, longest {:.2f} ms".format(*ms)


class _Received(NamedTuple):
    """A message: whether the echo sent it, the time of its frame (s of the take), and when it was here (monotonic s)."""

    echoed: bool
    time: float
    at: float


class _Client(Protocol):
    """A client outside that receives key frames, and the messages of the echo."""

    def receive(self, seconds: float) -> list[_Received]:
        """Return the messages within `seconds`, one at most."""


class _OscClient:
    def __init__(self, port: int, opened: contextlib.ExitStack) -> None:
        self._socket = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        self._socket.bind(("127.0.0.1", port))

    def receive(self, seconds: float) -> list[_Received]:
        self._socket.settimeout(max(seconds, 1e-4))
        try:
            data = self._socket.recv(65535)
        except TimeoutError:
            return []
        at = time.monotonic()
        messages = [timed.message for timed in OscPacket(data).messages]
        return [
            _Received(m.address == "/mossar/frame", m.params[_TIMES[m.address]], at)
            for m in messages
            if m.address in _TIMES
        ]


class _ZmqClient:
    def __init__(self, ports: tuple[int, int], opened: contextlib.ExitStack) -> None:
        self._socket: zmq.Socket[bytes] = opened.enter_context(zmq.Context.instance().socket(zmq.SUB))
        self._socket.setsockopt(zmq.LINGER, 0)
        for topic in (_KEY_FRAME, b"mossar.frame."):
            self._socket.setsockopt(zmq.SUBSCRIBE, topic)
        for port in ports:
            self._socket.connect(f"tcp://127.0.0.1:{port}")

    def receive(self, seconds: float) -> list[_Received]:
        if not self._socket.poll(int(seconds * 1000) + 1):
            return []
        topic, data = self._socket.recv_multipart()
        at = time.monotonic()
        if topic.startswith(_KEY_FRAME):
            return [_Received(False, msgspec.msgpack.decode(data, type=KeyFrameEvent).decided_time, at)]
        found = from_msgpack(data)
        return [_Received(True, found.t or 0.0, at)] if isinstance(found, FrameMap) else []


class _Stage:
    """A performance before `mossar run` and an echo, with one client for the messages of both.

    Args:
        client: Receives.
        through: Leads to `mossar run`.
        echo: Leads to the echo.
    """

    def __init__(self, client: _Client, through: FrameSink, echo: FrameSink) -> None:
        self.taken: dict[bool, list[float]] = {False: [], True: []}  # s, by whether the echo sent it
        self._client = client
        self._sinks = {False: through, True: echo}
        self._sent: dict[bool, list[float]] = {False: [], True: []}  # monotonic s at which each frame left
        self._fps = 0.0

    def perform(self, source: DemoSource) -> None:
        """Send a performance, and note the delays of the answers."""
        frames: list[Frames] = []
        for item in source.items():
            if isinstance(item, Meta):
                self._fps = item.fps or self._fps
                for sink in self._sinks.values():
                    sink.announce(item)
            elif isinstance(item, Frames):
                frames += [part(item, i, i + 1) for i in range(len(item))]
        self._await_echo(frames[0])
        began = time.monotonic()
        for number, frame in enumerate(frames):
            for echoed, late in ((False, 0.0), (True, 0.5)):
                self._receive(began + (number + late) / self._fps)
                self._sent[echoed].append(time.monotonic())
                self._sinks[echoed].send_frames(frame)
        self._receive(time.monotonic() + _LAST)

    def _await_echo(self, frame: Frames) -> None:
        until = time.monotonic() + _START
        self._sinks[True].send_frames(frame)
        while not any(message.echoed for message in self._client.receive(0.1)) and time.monotonic() < until:
            self._sinks[True].send_frames(frame)
        self._drop(0.2)

    def _drop(self, quiet: float) -> None:
        while self._client.receive(quiet):
            pass

    def _receive(self, until: float) -> None:
        while (left := until - time.monotonic()) > 0:
            for message in self._client.receive(left):
                sent = self._sent[message.echoed][round(message.time * self._fps)]
                self.taken[message.echoed].append(message.at - sent)
