"""Flood: `python -m checks.flood --rate 100000 --seconds 30`.

Rubbish is sent to the OSC port of a running pipeline, while a well-behaved sender goes on. Printed are that sender's
rate before, during and after, and the memory. A kernel cannot share a socket out fairly between senders, so frames get
lost while the flood lasts, and until the rest in the socket is processed. After that the sender's next frames must
all arrive, and the key frames of its next take must be those of a quiet run.
"""

import argparse
import itertools
import math
import multiprocessing
import random
import socket
import sys
import time
from collections.abc import Sequence
from multiprocessing.synchronize import Event as Signal
from typing import Any, NamedTuple

import msgspec
import numpy as np

from checks.soak.measure import memory
from mossar_adapters.address import parse_url
from mossar_adapters.demo import DemoSource
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.frame_sink import OscFrameSink
from mossar_adapters.osc.source import OscSource
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.source import Meta
from mossar_stream import Event, Frames, KeyFrameEvent

GOOD = "calm"  # the good sender; other programs of this computer may send a p1 to a port that was theirs
# The same sender's performer in the take after the flood: one without a past, since the estimates of a sensor's noise and
# of the range outlast takes, and lack the frames that the flood took.
NEXT_GOOD = "calmer"
FPS = 60.0
PHASE = 10.0  # s before the flood, and of the take after it
NEXT = 100  # frames after the flood that must all arrive
_CAUGHT_UP = 0.1  # s from sending to arriving, when nothing waits in the socket
_PATIENCE = 60.0  # s
_PAUSE = 1.5  # s before the take after the flood: longer than `max_pause`
_SEGMENTS = 60  # datagrams that one call sends, where the system can cut them apart
_UDP_SEGMENT = 103  # Linux's option for that, which the socket module lacks
_SIZES = (4, 16, 64, 200, 500)  # bytes of a rubbish datagram


class Result(msgspec.Struct):
    """Result of a run.

    Args:
        rates: The good sender's frames per second that arrived before, during and after.
        memory: Bytes before, the most during, and after.
        drained: Seconds after the flood until nothing waited in the socket any more.
        missing: How many of the next frames after that did not arrive.
        key_frames: Kind, and time since its first frame, of each final key frame of the last take.
        flood: Datagrams of rubbish per second that were really sent.
        drops: Datagrams that the kernel dropped.
    """

    rates: tuple[float, float, float]
    memory: tuple[int, int, int]
    drained: float
    missing: int
    key_frames: list[tuple[str, float]]
    flood: float
    drops: int


class Signals(NamedTuple):
    """Signals between the processes.

    Args:
        ready: The flood may begin.
        flooded: It is over.
        drained: The rest in the socket is processed.
        sent: The good sender is done.
    """

    ready: Signal
    flooded: Signal
    drained: Signal
    sent: Signal


class Listening:
    """Takes note of the times of the good sender's frames, of its key frames, and of the memory."""

    name = "listening"
    dropped = 0

    def __init__(self) -> None:
        self.times: list[float] = []
        self.events: list[Event] = []
        self.memory: list[tuple[float, int]] = []  # monotonic s, bytes
        self._measured = 0.0

    @property
    def newest(self) -> float:
        """Time of the newest frame, s."""
        return self.times[-1] if self.times else -math.inf

    def announce(self, meta: Meta) -> None:
        """Do nothing: there is one performer."""

    def send_frames(self, frames: Frames) -> None:
        """Note the times of frames."""
        if frames.performer in (GOOD, NEXT_GOOD):
            self.times += frames.times.tolist()

    def send(self, events: Sequence[Event]) -> None:
        """Note events."""
        self.events += [event for event in events if event.performer == NEXT_GOOD]

    def close(self) -> None:
        """Do nothing: there is nothing to release."""

    def tick(self) -> None:
        """Measure the memory twice a second."""
        now = time.monotonic()
        if now - self._measured > 0.5:
            self._measured = now
            self.memory.append((now, memory()))


def main() -> int:
    """Flood, compare with a quiet run, print, and return 1 if the flood did lasting harm."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.flood", description="Rubbish on the OSC port, and a sender who goes on."
    )
    parser.add_argument("--rate", metavar="N", type=float, default=100_000, help="datagrams per second")
    parser.add_argument("--seconds", metavar="S", type=float, default=30.0)
    given = parser.parse_args()
    quiet = flooded(0.0, PHASE)
    result = flooded(given.rate, given.seconds)
    before, during, after = result.rates
    low, high, end = (size / 2**20 for size in result.memory)
    print(
        f"rubbish: {result.flood:.0f} datagrams per second for {given.seconds:.0f} s; {result.drops} dropped by the kernel"
    )
    print(
        f"a sender of {FPS:.0f} frames per second: {before:.1f} before, {during:.1f} during, {after:.1f} after"
    )
    print(f"memory: {low:.1f} MB before, at most {high:.1f} MB during, {end:.1f} MB after")
    print(f"{result.drained:.1f} s after it nothing waited in the socket any more")
    print(f"of its next {NEXT} frames {NEXT - result.missing} arrived")
    same = result.key_frames == quiet.key_frames
    print(
        f"key frames of its next take: {len(result.key_frames)}, {'the same as' if same else 'NOT those'} in a quiet run"
    )
    if not same:
        print(f"{result.key_frames} instead of {quiet.key_frames}", file=sys.stderr)
    return 0 if same and result.key_frames and result.missing == 0 and high - low < 5 else 1


def flooded(rate: float, seconds: float, phase: float = PHASE) -> Result:
    """Run a pipeline and a good sender, and flood the port.

    Args:
        rate: Datagrams of rubbish per second; 0 for none.
        seconds: How long.
        phase: Seconds before the flood, and of the take after it.
    """
    context = multiprocessing.get_context("spawn")
    source, listening = OscSource(parse_url("osc://127.0.0.1:0")), Listening()
    signals = Signals(*(context.Event() for _ in Signals._fields))
    told: Any = context.Queue()
    senders = [
        context.Process(target=_behave, args=(source.port, phase, signals, told), daemon=True),
        context.Process(target=_flood, args=(source.port, rate, seconds, signals, told), daemon=True),
    ]
    for sender in senders:
        sender.start()
    facts: dict[str, float] = dict([told.get(timeout=_PATIENCE)])

    def tick() -> None:
        listening.tick()
        late = time.monotonic() - facts["began"] - listening.newest
        if signals.flooded.is_set() and late < _CAUGHT_UP:
            signals.drained.set()
        if signals.sent.is_set():
            while "last" not in facts:
                facts.update([told.get(timeout=_PATIENCE)])
            if listening.newest >= facts["last"] or late > _PATIENCE:
                pipeline.stop()

    pipeline = Pipeline([source], [listening], tick=tick)
    pipeline.run()
    for sender in senders:
        sender.join()
    return _result(listening, facts, phase, source.counters.kernel_drops)


def _result(listening: Listening, facts: dict[str, float], phase: float, drops: int) -> Result:
    """Return the result; the times of frames are seconds since the good sender began."""
    began, flood_began, flood_ended = facts["began"], facts["flood began"], facts["flood ended"]
    times = np.array(listening.times)
    first, last = flood_began - began, flood_ended - began
    calm = _resumed(listening.times)
    rates = (
        float((times < first).sum() / first),
        float(((times >= first) & (times < last)).sum() / (last - first)),
        float((times >= calm).sum() / phase),
    )
    used = [
        [size for moment, size in listening.memory if a <= moment < b] or [0]
        for a, b in ((began, flood_began), (flood_began, flood_ended), (flood_ended, float("inf")))
    ]
    next_frame = round(facts["next frame"])
    due = [k / FPS for k in range(next_frame, next_frame + NEXT)]
    missing = sum(not bool((np.abs(times - moment) < 1e-6).any()) for moment in due)
    final: list[tuple[str, float]] = [
        (event.kind, round(event.time - calm, 6))
        for event in listening.events
        if isinstance(event, KeyFrameEvent) and event.status == "final" and event.time >= calm
    ]
    used_memory = used[0][-1], max(used[1]), used[2][-1]
    return Result(rates, used_memory, next_frame / FPS - last, missing, final, facts["flood"], drops)


def _resumed(times: Sequence[float]) -> float:
    """Return the time of the first frame after the last pause."""
    pauses = [b for a, b in itertools.pairwise(times) if b - a > _PAUSE / 2]
    return pauses[-1] if pauses else 0.0


def _behave(port: int, phase: float, signals: Signals, told: Any) -> None:
    """Send the same motion to and fro until the flood is over and processed, and once more after a pause."""
    items = list(DemoSource(5, seconds=phase, speed="max").items())
    meta = msgspec.structs.replace(next(item for item in items if isinstance(item, Meta)), performer=GOOD)
    motion = np.concatenate([item.positions for item in items if isinstance(item, Frames)])
    sink = OscFrameSink(parse_url(f"osc://127.0.0.1:{port}?profile=mossar"))
    sink.announce(meta)
    sink.announce(msgspec.structs.replace(meta, performer=NEXT_GOOD))
    began = time.monotonic()
    told.put(("began", began))

    def send(k: int, place: int, who: str = GOOD) -> None:
        time.sleep(max(0.0, began + k / FPS - time.monotonic()))
        # To and fro: a jump back to the beginning would be a motion of its own where frames before it are lost.
        place %= 2 * len(motion)
        place = min(place, 2 * len(motion) - 1 - place)
        sink.send_frames(Frames(motion[place : place + 1], np.array([k / FPS]), performer=who))

    k = 0
    given_up = math.inf
    while not signals.drained.is_set() and time.monotonic() < given_up:
        if k == round(phase * FPS):
            signals.ready.set()
        if signals.flooded.is_set():
            given_up = min(given_up, time.monotonic() + _PATIENCE)
        send(k, k)
        k += 1
    told.put(("next frame", k))
    for following in range(k, k + NEXT):
        send(following, following)
    first = k + NEXT + round(_PAUSE * FPS)
    for place in range(round(phase * FPS)):
        send(first + place, place, NEXT_GOOD)
    told.put(("last", (first + round(phase * FPS) - 1) / FPS))
    signals.sent.set()


def _flood(port: int, rate: float, seconds: float, signals: Signals, told: Any) -> None:
    """Send rubbish when the other sender is ready for it."""
    rng = random.Random(1)  # noqa: S311 - not for secrets
    sent = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        wire.connect(("127.0.0.1", port))
        batches = [_rubbish(rng, size) for size in _SIZES for _ in range(8)]
        together = _cuts(wire)
        signals.ready.wait()
        began = time.monotonic()
        while (now := time.monotonic() - began) < seconds:
            if sent >= rate * now:
                time.sleep(0.0002)
                continue
            sent += _send(wire, batches[sent // _SEGMENTS % len(batches)], together)
        told.put(("flood began", began))
        told.put(("flood ended", time.monotonic()))
        told.put(("flood", sent / seconds))
        signals.flooded.set()


def _rubbish(rng: random.Random, size: int) -> list[bytes]:
    """Return datagrams of one size: noise, messages cut off, and messages of no profile."""
    whole = encode("/nobody/wants/this", "sfffb", GOOD, 0.1, 0.2, 0.3, bytes(size))
    frame = encode("/mossar/frame", "sidb", GOOD, 1, 0.0, bytes(size))
    kinds = (
        lambda: rng.randbytes(size),
        lambda: whole[:size].ljust(size, b"\0"),
        lambda: frame[:size].ljust(size, b"\xff"),
    )
    return [kinds[i % len(kinds)]() for i in range(_SEGMENTS)]


def _cuts(wire: socket.socket) -> bool:
    """Return whether the system cuts the data of one call into datagrams."""
    try:
        wire.setsockopt(socket.IPPROTO_UDP, _UDP_SEGMENT, _SIZES[0])
    except OSError:
        return False
    return True


def _send(wire: socket.socket, datagrams: Sequence[bytes], together: bool) -> int:
    """Send datagrams of one size and return their number."""
    try:
        if together:
            wire.setsockopt(socket.IPPROTO_UDP, _UDP_SEGMENT, len(datagrams[0]))
            wire.send(b"".join(datagrams))
        else:
            for datagram in datagrams:
                wire.send(datagram)
    except ConnectionError:  # no listener any more
        return len(datagrams)
    return len(datagrams)


if __name__ == "__main__":
    sys.exit(main())
