"""Lab Streaming Layer: a motion capture inlet, a marker outlet.

The inlet finds joints by channel labels as the XDF reader does, since XDF is how such streams are recorded.
Times are LSL's clock of this computer.
"""

import logging
import math
import time
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.address import Address
from mossar_adapters.extras import needed
from mossar_adapters.files.columns import Columns, find_columns
from mossar_adapters.files.options import ReadOptions, plausible_rate
from mossar_adapters.files.units import Scale, guessed_scale, height, metres_of, stated_scale
from mossar_adapters.files.xdf import channel_headings, unnamed_columns
from mossar_adapters.joint_sets import printable_names, with_known_parents
from mossar_adapters.live import Counters
from mossar_adapters.receiving.batch import FARTHEST
from mossar_adapters.receiving.pose import differ
from mossar_adapters.receiving.sender_clocks import SenderClock, Verdict
from mossar_adapters.source import Meta
from mossar_stream import (
    MAX_JOINTS,
    Event,
    Frames,
    MossarError,
    Skeleton,
    constant_times,
    narrow,
    performer_name,
    to_json,
)

OPTIONS = {
    "name": "name of the stream",
    "type": "type of the stream; default MoCap",
    "fps": "rate in Hz; replaces LSL's times",
    "unit": "m, cm, mm, inch or auto",
    "performer": "name of the performer",
}
SINK_OPTIONS = {"name": "name of the marker stream; default mossar"}
_POLL = 0.1  # s
_SEARCH = 0.5  # s for one look around
_CHUNK = 512  # samples
_BUFFER = 60  # s of samples that LSL keeps
_log = logging.getLogger("mossar.source")
_FIELDS = ("label", "type", "unit", "marker", "object")


class _Sample(NamedTuple):
    """Positions (J, 3), metres, and confidence (J,) or None of one frame."""

    positions: NDArray[Any]
    confidence: NDArray[np.float32] | None


Timed = Sequence[tuple[_Sample, float]]  # frames with their times, s


class LslSource:
    """Reads a motion capture stream; implements `Source`. It waits for the stream to appear.

    Args:
        address: `lsl:` or `lsl:?name=…`.
        options: The user's fps and unit.

    Raises:
        MossarError: If an option is wrong or the extra `lsl` is not installed.
    """

    live = True

    def __init__(self, address: Address, options: ReadOptions | None = None) -> None:
        needed("pylsl", "lsl", address.url)
        address.check(OPTIONS)
        self.name = address.url
        self.counters = Counters()
        self._options = options or ReadOptions()
        self._wanted = ("name", address.options["name"]) if "name" in address.options else None
        self._type = address.options.get("type", "MoCap")
        self._performer = performer_name(address.options.get("performer", "p1"))
        self._scale: Scale | None = None
        self._count = 0  # frames so far
        self._clock = SenderClock(Verdict(), _differ, self._note)
        self._pulled = time.monotonic()  # s, when samples were pulled last
        self._found = ""  # name of the stream
        self._closed = False

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield a meta and chunks of frames; None while nothing comes."""
        inlet = None
        while inlet is None:
            if self._closed:
                return
            inlet = self._search()
            yield None
        try:
            description = inlet.info(timeout=10.0)
            columns, unit = _columns(self.name, description)
            skeleton = printable_names(Skeleton(columns.joints, *with_known_parents(columns.joints)))
            nominal = float(description.nominal_srate())
            fps = self._options.fps or (nominal if plausible_rate(nominal) else None)
            announced = False
            while not self._closed:
                samples, times = inlet.pull_chunk(timeout=_POLL, max_samples=_CHUNK)
                if times and not announced:
                    announced = True
                    self._measure(np.array(samples, dtype=np.float64), columns, unit)
                    yield Meta(self._performer, skeleton, fps, (self._scale and self._scale.note) or "m")
                frames = self._frames(self._timed(samples, times, columns))
                yield frames
            last = self._frames(self._clock.settle(math.inf))
            if last is not None:
                yield last
        finally:
            inlet.close_stream()

    def explain(self) -> str:
        """Return one line about the stream that is sought or read."""
        if not self._found:
            wanted = f"called {self._wanted[1]!r}" if self._wanted else f"of type {self._type!r}"
            return f"{self.name}: no LSL stream {wanted} is to be seen; is the sender on this network?"
        return f"{self.name}: reading the LSL stream {self._found!r}; {self.counters.received} samples came"

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed = True

    def _search(self) -> Any:
        import pylsl

        prop, value = self._wanted or ("type", self._type)
        found = pylsl.resolve_byprop(prop, value, 1, _SEARCH)
        if not found:
            return None
        self._found = found[0].name()
        return pylsl.StreamInlet(found[0], max_buflen=_BUFFER, processing_flags=pylsl.proc_clocksync)

    def _measure(self, samples: NDArray[np.float64], columns: Columns, unit: str) -> None:
        """Find the scale of a stream by its first samples."""
        stated = metres_of(unit)
        self._scale = (
            stated_scale(self._options, stated)
            if stated
            else guessed_scale(self._options, height(_joints(samples, columns)))
        )

    def _timed(self, samples: Sequence[Any], times: Sequence[float], columns: Columns) -> Timed:
        """Return the frames whose times are settled, among them those held back before."""
        before, self._pulled = self._pulled, time.monotonic()
        if not times or self._scale is None:
            return self._clock.settle(self._pulled)
        self.counters.received += len(times)
        table = np.array(samples, dtype=np.float64)
        positions = _joints(table, columns) * self._scale.metres
        with np.errstate(invalid="ignore"):
            positions[~(np.abs(positions) < FARTHEST).all(axis=2)] = np.nan
        found = [_Sample(pose, None) for pose in narrow(positions)]
        if columns.confidence:
            confidence = np.clip(np.nan_to_num(table[:, list(columns.confidence)]), 0, 1).astype(np.float32)
            found = [sample._replace(confidence=sure) for sample, sure in zip(found, confidence, strict=True)]
        count, self._count = self._count, self._count + len(times)
        if self._options.fps is not None:
            clock = constant_times(len(times), self._options.fps, count).tolist()
            return list(zip(found, clock, strict=True))
        # Samples that are pulled together came in sequence since the last pull.
        arrivals = np.linspace(before, self._pulled, len(times) + 1)[1:].tolist()
        timed = [
            one
            for sample, sent, arrival in zip(found, times, arrivals, strict=True)
            for one in self._clock.put(sample, sent, arrival)
        ]
        self.counters.retimed += self._clock.changed
        self._clock.changed = 0
        return timed

    def _frames(self, timed: Timed) -> Frames | None:
        if not timed:
            return None
        samples, times = zip(*timed, strict=True)
        confidence = None if samples[0].confidence is None else np.array([s.confidence for s in samples])
        positions = np.array([sample.positions for sample in samples])
        return Frames(positions, np.array(times), confidence, self._performer)

    def _note(self, text: str) -> None:
        _log.warning("%s: %s", self.name, text)


def _joints(samples: NDArray[np.float64], columns: Columns) -> NDArray[np.float64]:
    """Return the positions in samples, (n, J, 3) in the stream's unit."""
    return samples[:, [column for xyz in columns.xyz for column in xyz]].reshape(len(samples), -1, 3)


def _differ(one: _Sample, other: _Sample) -> bool:
    return differ(one.positions, other.positions)


class LslSink:
    """Sends every event as a JSON marker; implements `Sink`. The marker's time is that of sending.

    Args:
        address: `lsl:` or `lsl:?name=…`.

    Raises:
        MossarError: If an option is wrong or the extra `lsl` is not installed.
    """

    def __init__(self, address: Address) -> None:
        needed("pylsl", "lsl", address.url)
        address.check(SINK_OPTIONS)
        import pylsl

        self.name = address.url
        self.dropped = 0
        name = address.options.get("name", "mossar")
        info = pylsl.StreamInfo(name, "Markers", 1, pylsl.IRREGULAR_RATE, "string", f"mossar-{name}")
        self._outlet: Any = pylsl.StreamOutlet(info)

    def announce(self, meta: Meta) -> None:
        """Do nothing: the events name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Send markers."""
        for event in events:
            self._outlet.push_sample([to_json(event).decode()])

    def close(self) -> None:
        """Close the outlet. May be called twice."""
        if self._outlet is not None:
            time.sleep(0.05)  # LSL sends from a thread of its own and drops unsent samples
            self._outlet = None


def _columns(name: str, description: Any) -> tuple[Columns, str]:
    """Return the places of the joints in a sample, and the unit."""
    count = description.channel_count()
    channels: list[dict[str, list[str]]] = []
    channel = description.desc().child("channels").child("channel")
    while not channel.empty() and len(channels) < count:
        channels.append({field: [channel.child_value(field)] for field in _FIELDS})
        channel = channel.next_sibling("channel")
    info = {"desc": [{"channels": [{"channel": channels}]}]}
    headings, unit = channel_headings(info, count)
    columns = find_columns(headings) or unnamed_columns(name, count)
    if not 1 <= len(columns.joints) <= MAX_JOINTS:
        raise MossarError(f"{name}: {len(columns.joints)} joints; 1 to {MAX_JOINTS} can be used")
    return columns, unit
