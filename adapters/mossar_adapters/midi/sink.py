"""The MIDI sink: a note for each key frame, the clock for the tempo of repetitions, controllers for followed moves, notes for held poses.

Onsets, minima and offsets are three notes; each performer has a channel. One cycle of a repeated movement is a quarter
note of the clock, or `?beats=` of them; the clock runs from the second cycle on and stops when the repetitions do.
A followed move has a controller for its progress, 20 for the first one that is made. When it is done it has a note, 72 for the
first one, whose velocity is the score. A pose that is held sounds as a note from `held` to `left`, 84 for the first.
"""

from collections.abc import Sequence

from mossar_adapters.address import Address
from mossar_adapters.midi.player import Player
from mossar_adapters.midi.ports import open_port
from mossar_adapters.source import Meta
from mossar_stream import (
    BODY,
    Event,
    FollowEvent,
    KeyFrameEvent,
    KeyFrameKind,
    PoseEvent,
    RepetitionEvent,
    StreamEvent,
)

OPTIONS = {
    "name": "name of the virtual port; default mossar",
    "port": "part of the name of a port that is there",
    "notes": "of onset, minimum and offset, 0 to 127; default 60,64,67",
    "beats": "quarter notes of the clock in a cycle, 1 to 16; default 1",
}
KINDS: tuple[KeyFrameKind, ...] = ("onset", "minimum", "offset")
NOTES = "60,64,67"
VELOCITY = 100
LENGTH = 0.1  # s, of a note
CHANNELS = 16
CONTROLLER = 20  # of the first followed move; 20 to 31 have no meaning of their own in MIDI
FIRST_DONE = 72  # note of the first followed move when it is done
FOLLOWED = 12  # moves that have a controller and a note
FIRST_HELD = 84  # note of the first pose while it is held
POSES = 12  # that have a note
SILENCE = 2.5  # cycles without a new one, after which the clock stops


class MidiSink:
    """Plays events; implements `Sink`.

    Args:
        address: `midi:` for a virtual port, `midi:?port=NAME` for one that is there, `midi:PATH` for bytes.
        force: Whether to replace a file that is there.

    Raises:
        MossarError: If the port or file cannot be had, an option is wrong or the extra `midi` is not installed.
    """

    prompt = True

    def __init__(self, address: Address, *, force: bool = False) -> None:
        address.check(OPTIONS)
        self.name = address.url
        self.dropped = 0
        self._notes = dict(zip(KINDS, _notes(address), strict=True))
        self._beats = address.number("beats", 1, 16, 1) or 1
        self._channels: dict[str, int] = {}
        self._leader = ""  # performer of the clock
        self._followed: dict[str, int] = {}  # places of followed moves, in the order of their first events
        self._poses: dict[str, int] = {}  # the same of poses
        self._port = open_port(address, replace=force)
        self._player = Player(self._port)

    def announce(self, meta: Meta) -> None:
        """Give a performer a channel."""
        self._channel(meta.performer)

    def send(self, events: Sequence[Event]) -> None:
        """Play events.

        Raises:
            Exception: The error that ended the port.
        """
        if self._player.error is not None:
            raise self._player.error
        self.dropped = self._player.dropped
        for event in events:
            match event:
                case KeyFrameEvent(status="confirmed"):
                    channel = self._channel(event.performer)
                    self._player.note(channel, self._notes[event.kind], VELOCITY, LENGTH)
                case RepetitionEvent(channel=channel) if channel == BODY:
                    self._keep_time(event)
                case FollowEvent():
                    self._play_along(event)
                case PoseEvent(status="held" | "left"):
                    self._sound(event)
                case StreamEvent(event="ended" | "stalled") if event.performer == self._leader:
                    self._player.rest()
                    self._leader = ""
                case _:
                    pass

    def close(self) -> None:
        """End notes and clock and release the port. May be called twice."""
        self._player.close()
        self._port.close()

    def _keep_time(self, event: RepetitionEvent) -> None:
        if event.period is not None and self._leader in {"", event.performer}:
            self._leader = event.performer
            self._player.beat(event.period / self._beats, SILENCE * event.period)

    def _play_along(self, event: FollowEvent) -> None:
        """Turn the controller of a followed move to its progress; play its note when it is done."""
        place = self._followed.setdefault(event.name, len(self._followed))
        if place >= FOLLOWED:
            return
        channel = self._channel(event.performer)
        over = event.status in {"done", "left"}
        self._player.control(channel, CONTROLLER + place, 0 if over else round(127 * event.progress))
        if event.status == "done":
            loudness = max(1, round(127 * (event.score or 0.0)))
            self._player.note(channel, FIRST_DONE + place, loudness, LENGTH)

    def _sound(self, event: PoseEvent) -> None:
        """Begin the note of a pose that is held, or end it."""
        place = self._poses.setdefault(event.name, len(self._poses))
        if place >= POSES:
            return
        channel, note = self._channel(event.performer), FIRST_HELD + place
        if event.status == "held":
            self._player.hold(channel, note, VELOCITY)
        else:
            self._player.release(channel, note)

    def _channel(self, performer: str) -> int:
        return self._channels.setdefault(performer, len(self._channels)) % CHANNELS


def _notes(address: Address) -> list[int]:
    text = address.options.get("notes", NOTES)
    try:
        notes = [int(part) for part in text.split(",")]
    except ValueError:
        notes = []
    if len(notes) != len(KINDS) or not all(0 <= note <= 127 for note in notes):
        raise address.error(
            f"option notes must be three numbers from 0 to 127, as {NOTES}, not {text[:40]!r}"
        )
    return notes
