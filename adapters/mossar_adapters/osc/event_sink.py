"""The OSC event sink: one message per event, times in seconds since the take's first frame.

`/mossar/key_frame ,sssiiffffi` performer, status, kind, take, frame, time, decided time, velocity, strength (-1
until computed), rev; `/mossar/segment ,sssiiiff` performer, status, state, take, start frame, end frame, start
time, end time; both of a limb as `/mossar/limb/key_frame ,ssssiiffffi` and `/mossar/limb/segment ,ssssiiiff` with the
channel after the performer; `/mossar/move ,ssssiffffi` performer, status, name, limb, take, start, end, decided time, score, rev;
`/mossar/follow ,sssssiiffffffffsi` performer, status, name, limb that strays most, joint, take, count, progress, tempo,
certainty, deviation, score (-1 until done), start, time, decided time, id, rev, then `sff` for each limb: name,
deviation, range (-1 until done, and of limbs that stand still);
`/mossar/pose ,sssssiffffsi` performer, status, name, limb that strays most, joint, take, start, seconds, deviation, decided time,
id, rev, then `sf` for each limb: name, deviation;
`/mossar/repetition ,sssiiiffsi` performer, status, channel, take, count, total, period, tempo (-1 for the first of a bout), id, rev;
`/mossar/phase ,ssif` performer, channel, take, phase from 0 to 1, -1 once when nothing repeats any more;
`/mossar/activity ,sssifff` performer, channel, state, take, start, decided time, previous (-1 at first);
`/mossar/run ,ss` performer, run, before each take; `/mossar/stream ,sssi` performer, event, reason, take.
"""

from collections.abc import Sequence

from mossar_adapters.address import Address
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.sender import DatagramSender
from mossar_adapters.source import Meta
from mossar_stream import (
    BODY,
    ActivityEvent,
    Event,
    FollowEvent,
    KeyFrameEvent,
    MoveEvent,
    PhaseEvent,
    PoseEvent,
    RepetitionEvent,
    SegmentEvent,
    StepEvent,
    StreamEvent,
)

_MAX_PERFORMERS = 1024

_Timed = KeyFrameEvent | SegmentEvent | ActivityEvent | MoveEvent | FollowEvent | PoseEvent | StepEvent


class OscSink:
    """Sends events over OSC; implements `Sink`.

    Args:
        address: `osc://HOST:PORT`.

    Raises:
        MossarError: If the host is unknown or an option is wrong.
    """

    prompt = True

    def __init__(self, address: Address) -> None:
        address.check({})
        self.name = address.url
        self.dropped = 0
        self._sender = DatagramSender(address)
        self._starts: dict[
            str, tuple[int, float]
        ] = {}  # performer -> take and the time of its first frame, s

    def announce(self, meta: Meta) -> None:
        """Do nothing: the messages name their performer."""

    def begin_take(self, performer: str, take: int, time: float) -> None:
        """Take note of when a take began.

        Without this call the beginning is reckoned from the frame number and time of the take's first event.

        Args:
            performer: Name.
            take: Its number.
            time: Source time of its first frame, s.
        """
        if len(self._starts) == _MAX_PERFORMERS and performer not in self._starts:
            del self._starts[next(iter(self._starts))]
        self._starts[performer] = (take, time)

    def send(self, events: Sequence[Event]) -> None:
        """Send events, one datagram each; stats are not sent."""
        for event in events:
            if isinstance(event, StreamEvent) and event.run is not None:
                self._put(encode("/mossar/run", "ss", event.performer, event.run))
            data = self._written(event)
            if data:
                self._put(data)

    def close(self) -> None:
        """Release the socket. May be called twice."""
        self._sender.close()

    def _put(self, data: bytes) -> None:
        if not self._sender.send(data):
            self.dropped += 1

    def _written(self, event: Event) -> bytes:
        """Return an event as a message, empty for stats."""
        match event:
            case KeyFrameEvent():
                return self._key_frame(event)
            case SegmentEvent():
                return self._segment(event)
            case ActivityEvent():
                return self._activity(event)
            case MoveEvent():
                return self._move(event)
            case FollowEvent():
                return self._follow(event)
            case PoseEvent():
                return self._pose(event)
            case RepetitionEvent():
                numbers = (event.take, event.count, event.total, event.period or -1.0, event.tempo or -1.0)
                who = (event.performer, event.status, event.channel)
                return encode("/mossar/repetition", "sssiiiffsi", *who, *numbers, event.id, event.rev)
            case PhaseEvent():
                where = (event.take, -1.0 if event.phase is None else event.phase)
                return encode("/mossar/phase", "ssif", event.performer, event.channel, *where)
            case StepEvent():
                return self._step(event)
            case StreamEvent():
                words = (event.performer, event.event, event.reason)
                return encode("/mossar/stream", "sssi", *words, event.take)
            case _:
                return b""

    def _key_frame(self, event: KeyFrameEvent) -> bytes:
        start = self._start(event)
        strength = -1.0 if event.strength is None else event.strength
        address, who = _addressed("key_frame", event)
        return encode(
            address,
            "s" * len(who) + "ssiiffffi",
            *who,
            *(event.status, event.kind, event.take, event.frame),
            *(event.time - start, event.decided_time - start, event.velocity, strength, event.rev),
        )

    def _segment(self, event: SegmentEvent) -> bytes:
        start = self._start(event)
        address, who = _addressed("segment", event)
        return encode(
            address,
            "s" * len(who) + "ssiiiff",
            *who,
            *(event.status, event.state, event.take, event.start_frame, event.end_frame),
            *(event.start_time - start, event.end_time - start),
        )

    def _move(self, event: MoveEvent) -> bytes:
        start = self._start(event)
        return encode(
            "/mossar/move",
            "ssssiffffi",
            *(event.performer, event.status, event.name, event.limb, event.take),
            *(event.start - start, event.end - start, event.decided_time - start, event.score, event.rev),
        )

    def _follow(self, event: FollowEvent) -> bytes:
        start = self._start(event)
        score, ranges = -1.0 if event.score is None else event.score, event.range or {}
        limbs = [(name, angle, ranges.get(name, -1.0)) for name, angle in event.limbs.items()]
        return encode(
            "/mossar/follow",
            "sssssiiffffffffsi" + "sff" * len(limbs),
            *(event.performer, event.status, event.name, event.limb, event.joint, event.take, event.count),
            *(event.progress, event.tempo, event.certainty, event.deviation, score),
            *(event.start - start, event.time - start, event.decided_time - start, event.id, event.rev),
            *(part for limb in limbs for part in limb),
        )

    def _pose(self, event: PoseEvent) -> bytes:
        start = self._start(event)
        return encode(
            "/mossar/pose",
            "sssssiffffsi" + "sf" * len(event.limbs),
            *(event.performer, event.status, event.name, event.limb, event.joint, event.take),
            *(event.start - start, event.seconds, event.deviation, event.decided_time - start),
            *(event.id, event.rev),
            *(part for limb in event.limbs.items() for part in limb),
        )

    def _activity(self, event: ActivityEvent) -> bytes:
        start = self._start(event)
        previous = -1.0 if event.previous is None else event.previous
        words = (event.performer, event.channel, event.state)
        times = (event.start - start, event.decided_time - start, previous)
        return encode("/mossar/activity", "sssifff", *words, event.take, *times)

    def _step(self, event: StepEvent) -> bytes:
        start = self._start(event)
        times = event.time - start, event.decided_time - start
        return encode(
            "/mossar/step",
            "sssiffffffs",
            *(event.performer, event.status, event.side, event.take, *times, event.confidence),
            *(*event.position, event.id),
        )

    def _start(self, event: _Timed) -> float:
        known = self._starts.get(event.performer)
        if known is None or known[0] != event.take:
            self.begin_take(event.performer, event.take, _reckoned(event))
        return self._starts[event.performer][1]


def _addressed(what: str, event: KeyFrameEvent | SegmentEvent) -> tuple[str, list[str]]:
    """Return where a message goes, and of whom it tells: patches for the body's must not hear of limbs."""
    if event.channel == BODY:
        return f"/mossar/{what}", [event.performer]
    return f"/mossar/limb/{what}", [event.performer, event.channel]


def _reckoned(event: _Timed) -> float:
    """Return when frame 0 was, going back from two frames at their mean rate; a move or activity knows no frames."""
    if isinstance(event, MoveEvent | FollowEvent | PoseEvent | ActivityEvent):
        return event.start
    if isinstance(event, StepEvent):
        return event.time
    if isinstance(event, SegmentEvent):
        first, last = (event.start_frame, event.start_time), (event.end_frame, event.end_time)
    else:
        first, last = (event.frame, event.time), (event.decided_frame, event.decided_time)
    frames = last[0] - first[0]
    step = (last[1] - first[1]) / frames if frames > 0 else 0.0
    return first[1] - first[0] * step
