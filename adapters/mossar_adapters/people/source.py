"""A source whose performers are slots: `p1` to `pN`, independent of its tracker's ids.

Frames that go on under a known id are passed on at once. If an id is new, was away or leaps, a decision is needed: the
frames from that moment on wait until the source shows that the moment is over: with the next frame of the same
performer, a later one of others, or a tenth of a second without any. A new id can thus take the slot of one that is missing
in the same frame. Slots are given in the order of the frames' times. Frames of an id that is observed wait for up to
two seconds, and then go on with their own times.
"""

import logging
import threading
import time
from collections import OrderedDict
from collections.abc import Generator, Iterator
from typing import Any, Final

import msgspec
import numpy as np

from mossar_adapters.abilities import Orders, Resumes, offered
from mossar_adapters.people.body import PAUSE
from mossar_adapters.people.given import People, checked_people, checked_seconds
from mossar_adapters.people.slot_table import REFUSED, REMEMBERED, Change
from mossar_adapters.people.slots import BACK, UNDECIDED, Slots
from mossar_adapters.replay.interleaving import part
from mossar_adapters.source import Departure, Item, Meta, Occupant, Source
from mossar_stream import Frames, SnapshotError

_IDS: Final = 256  # whose skeletons are remembered
_HELD: Final = 512  # frames that wait for a decision on their id
_HAND_OVER: Final = 1.0  # s after a person has left in which another id may go on with its take
# A new id of a live source has a clock of its own if its times lie so far before or behind those of the others.
_BEHIND: Final = 60.0  # s; less may be a pause in a recording that is played fast
_STEP: Final = 1 / 30  # s, where no rate is known
_MOST_LOGGED: Final = 20  # refused ids that are logged

_log = logging.getLogger("mossar.people")


class _Kept(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The memory of slots, and when it was made, s since the epoch."""

    slots: bytes
    at: float


_encoder = msgspec.msgpack.Encoder()
_decoder = msgspec.msgpack.Decoder(_Kept)


class PeopleSource:
    """Passes a source on under the names of slots; all else about it is the source's own.

    Args:
        source: Source of the frames; its performers' names are the sender's ids.
        people: How many slots, or `"nearest"` or `"first"`; see `Slots`.
        remember: Time for which an absent person keeps a slot, s.
    """

    def __init__(self, source: Source, people: People, remember: float = REMEMBERED) -> None:
        self.name, self.live = source.name, source.live
        self.came = None  # not offered: the source knows other names than those of slots
        self._source = source
        if (ordering := offered(source, Orders)) is not None:
            ordering.in_order = True  # readers keep chunks back, each performer's for itself
        self._slots = Slots(people, remember)
        self._lock = threading.Lock()  # requests come from other threads
        self._metas: OrderedDict[str, Meta] = OrderedDict()  # by id
        self._ranks: dict[str, int] = {}  # by id, in the order in which they were announced first
        self._announced = 0
        self._sent: dict[str, Meta] = {}  # the latest of each slot
        self._begun: set[str] = set()  # slots that frames were passed on of
        self._pending: dict[str, Frames] = {}  # by id, from the first undecided moment on
        self._held: dict[str, list[Frames]] = {}  # of observed ids
        self._left: dict[str, tuple[Departure, float]] = {}  # by slot, with the monotonic time, s
        self._shifts: OrderedDict[str, float] = OrderedDict()  # s that are added to the times of an id
        self._now = -np.inf  # s, the latest time
        self._arrived = 0.0  # monotonic s, when the latest frames came
        self._straight: dict[str, str] = {}  # slots of ids whose frames need nothing but another name
        self._skip: dict[str, int] = {}  # frames of each slot that were used before
        self._logged = 0
        self._occupants: dict[str, str] = {}  # the latest id of each slot
        self._latest: Frames | None = None  # that were passed on, where one slot goes from person to person
        self._anew: set[str] = set()  # slots to be announced again, because they have other people now
        self._recalled: float | None = None  # s since the epoch, last time of the recalled people

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    @property
    def people(self) -> "PeopleSource":
        """This source; other sources have no slots."""
        return self

    def set(self, people: object = None, remember: object = None) -> None:
        """Change the number of followed people, and the time for which absent ones are remembered.

        Args:
            people: As for `Slots`; None to leave it. Slots for the nearest or first begin anew.
            remember: Seconds; None to leave it.

        Raises:
            SettingsError: If a value is impossible; nothing is changed then.
        """
        with self._lock:
            slots = self._slots
            seconds = checked_seconds("remember", slots.remember if remember is None else remember)
            wanted = checked_people(slots.people if people is None else people)
            if isinstance(wanted, int) and isinstance(slots.people, int):
                slots.resize(wanted)
                slots.remember = seconds
            elif wanted == slots.people:
                slots.remember = seconds
            else:
                fresh = Slots(wanted, seconds)
                self._slots, self._anew = fresh, set(self._begun)
                for ident, meta in self._metas.items():
                    fresh.announce(ident, meta.skeleton)

    @property
    def performers(self) -> tuple[str, ...]:
        """The names that performers may have."""
        return self._slots.names

    @property
    def recording(self) -> None:
        """None: the played frames differ from the recording."""
        return

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def resume(self, position: dict[str, int]) -> None:
        """Begin behind the first `position[slot]` frames of each slot; before `items`."""
        if offered(self._source, Resumes) is not None:
            self._skip = dict(position)

    def to_bytes(self) -> bytes:
        """Return the state of all people, for `recall` of a later run."""
        with self._lock:
            return _encoder.encode(_Kept(self._slots.to_bytes(), time.time()))

    def recall(self, data: bytes) -> None:
        """Go on with the people of a run that was cut short; before `items`.

        A recording is played from its beginning, which gives the same people the same slots: it needs no memory. The
        state of people who cannot be recalled is forgotten, which is logged.

        Args:
            data: From `to_bytes`; empty if the other run had no slots.
        """
        if offered(self._source, Resumes) is not None:
            return
        try:
            kept = _decoder.decode(data)
            self._slots.recall(kept.slots)
        except (msgspec.DecodeError, SnapshotError) as error:
            self._anew = set(self._slots.names)
            if data:
                _log.warning("%s: %s; everybody is new", self.name, error)
            return
        self._recalled = kept.at
        rows = self._slots.table()
        self._occupants = {str(row["slot"]): str(row["id"]) for row in rows}
        self._begun = set(self._occupants)
        if rows:
            known = ", ".join(f"{slot} was {shown(ident)}" for slot, ident in self._occupants.items())
            _log.info("%s: people of the last run are remembered: %s", self.name, known)

    def table(self) -> list[dict[str, object]]:
        """Return the slots and their people; see `Slots.table`."""
        with self._lock:
            return self._slots.table()

    def exchange(self, one: str, other: str) -> None:
        """Exchange the slots of two people; see `Slots.exchange`."""
        with self._lock:
            self._slots.exchange(one, other)

    def pin(self, slot: str, *, pinned: bool = True) -> None:
        """Keep a slot for its person; see `Slots.pin`."""
        with self._lock:
            self._slots.pin(slot, pinned=pinned)

    def items(self) -> Iterator[Item]:
        """Yield the items of the source, under the names of slots."""
        for item in self._source.items():
            with self._lock:
                found = self.take(item)
            yield from found
            if item is None:
                yield None
        with self._lock:
            found = [kept for one in self._rest() if (kept := self._unused(one)) is not None]
        yield from found

    def take(self, item: Item) -> list[Item]:
        """Process an item of the source, and return the items that go on."""
        slot: str | None = REFUSED
        count = 0
        if isinstance(item, Frames) and not (self._pending or self._held or self._left or self._skip):
            expected = self._straight.get(item.performer)
            if expected is not None:  # nearly always
                slot, count = self._slots.run(item.performer, item.positions, item.times)
                if slot == expected and count == len(item) and not self._slots.changed:
                    self._now = max(self._now, float(item.times[-1]))
                    self._arrived = time.monotonic()
                    self._latest = item
                    return [msgspec.structs.replace(item, performer=slot)]
        return [kept for one in self._of(item, slot, count) if (kept := self._unused(one)) is not None]

    def _of(self, item: Item, slot: str | None, count: int) -> Iterator[Item]:
        """Yield the items that go on with an item, of whose frames so many have been followed already."""
        if isinstance(item, Frames):
            if count:
                yield from self._route(slot, part(item, 0, count))
                item = part(item, count, len(item))
            if len(item):
                yield from self._take(item)
        elif isinstance(item, Meta):
            yield from self._announce(item)
        elif isinstance(item, Departure):
            yield from self._leave(item)
        elif item is None:
            yield from self._decide_all()
        if self._held:
            yield from self._settle(self._now - PAUSE)
        if self._left:
            yield from self._farewells(time.monotonic() - _HAND_OVER)

    def _rest(self) -> Iterator[Item]:
        yield from self._decide_all()
        yield from self._settle(float("inf"))
        yield from self._farewells(float("inf"))

    def _announce(self, meta: Meta) -> Iterator[Item]:
        known = self._metas.get(meta.performer)
        if known is not None and known.skeleton != meta.skeleton:
            yield from self._decide_all()
        self._straight.clear()
        self._slots.announce(meta.performer, meta.skeleton)
        self._metas[meta.performer] = meta
        self._metas.move_to_end(meta.performer)
        self._ranks.setdefault(meta.performer, self._announced)
        self._announced += 1
        if len(self._metas) > _IDS:
            self._ranks.pop(self._metas.popitem(last=False)[0])

    def _leave(self, left: Departure) -> Iterator[Item]:
        """Keep a farewell back for as long as another id may go on with the take."""
        yield from self._decide_all()
        yield from self._settle(float("inf"), left.performer)
        slot = self._slots.slot_of(left.performer)
        self._slots.leave(left.performer)
        if slot is not None:
            self._left[slot] = left, time.monotonic()

    def _farewells(self, until: float) -> Iterator[Item]:
        for slot, (left, at) in list(self._left.items()):
            if at <= until:
                del self._left[slot]
                yield Departure(slot, left.reason)

    def _take(self, frames: Frames) -> Iterator[Item]:
        frames = self._on_one_clock(frames)
        ident, times = frames.performer, frames.times
        if self._recalled is not None:
            self._slots.restart(float(times[0]), max(_HAND_OVER, time.time() - self._recalled))
            self._recalled = None
        if times[-1] < self._now - BACK and self._slots.went_back(ident, float(times[-1])):
            yield from self._start_over(float(times[0]))
        pending = self._pending
        if pending and (ident in pending or times[0] > max(float(f.times[-1]) for f in pending.values())):
            yield from self._decide_all()
        self._now = max(self._now, float(times[-1]))
        self._arrived = time.monotonic()
        end = len(frames)
        if pending:
            end = int(times.searchsorted(min(float(f.times[0]) for f in pending.values())))
        begin = yield from self._run(frames, end)
        if begin < len(frames):
            pending[ident] = frames if begin == 0 else part(frames, begin, len(frames))

    def _run(self, frames: Frames, end: int) -> Generator[Item, None, int]:
        """Pass frames on as far as nothing has to be decided; return their number."""
        begin = 0
        while begin < end:
            slot, count = self._slots.run(
                frames.performer, frames.positions[begin:end], frames.times[begin:end]
            )
            if not count:
                break
            whole = begin == 0 and count == len(frames)
            yield from self._route(slot, frames if whole else part(frames, begin, begin + count))
            begin += count
        return begin

    def _decide_all(self) -> Iterator[Item]:
        """Decide the waiting items, moment by moment."""
        pending = self._pending
        while pending:
            moment = min(float(frames.times[0]) for frames in pending.values())
            found = [ident for ident, frames in pending.items() if float(frames.times[0]) == moment]
            # Within one moment the order is the sender's, not that in which the chunks were filled.
            found.sort(key=lambda ident: self._ranks.get(ident, self._announced))
            poses = [(ident, pending[ident].positions[0]) for ident in found]
            verdicts = self._slots.decide(moment, poses, chunks=True)
            for ident, slot in zip(found, verdicts, strict=True):
                frames = pending.pop(ident)
                yield from self._route(slot, part(frames, 0, 1))
                if len(frames) > 1:
                    pending[ident] = part(frames, 1, len(frames))
            for ident in list(pending):
                frames = pending.pop(ident)
                others = [float(f.times[0]) for f in pending.values()]
                end = int(frames.times.searchsorted(min(others))) if others else len(frames)
                begin = yield from self._run(frames, end)
                if begin < len(frames):
                    pending[ident] = part(frames, begin, len(frames))

    def _start_over(self, moment: float) -> Iterator[Item]:
        """Go on with a clock that was set back to a moment, s."""
        yield from self._decide_all()
        yield from self._settle(float("inf"))
        seconds = self._slots.restart(moment)
        for ident, shift in self._shifts.items():
            self._shifts[ident] = shift and shift + seconds  # clocks of others were not set back
        self._now = moment
        self._latest = None

    def _settle(self, until: float, only: str | None = None) -> Iterator[Item]:
        """Decide on observed ids that were not seen since."""
        for ident, last in self._slots.waiting():
            if last <= until and only in {None, ident} and ident not in self._pending:
                slot = self._slots.settle(ident)
                yield from self._report()
                yield from self._release(ident, slot)

    def _route(self, slot: str | None, frames: Frames) -> Iterator[Item]:
        """Pass frames on, or keep them until it is decided whose they are."""
        if self._slots.changed:
            yield from self._report()
        if slot is UNDECIDED:
            held = self._held.setdefault(frames.performer, [])
            held.append(frames)
            if len(self._held) > _IDS:
                del self._held[next(iter(self._held))]
            elif len(held) > _HELD:
                yield from self._release(frames.performer, self._slots.settle(frames.performer))
            return
        if frames.performer in self._held:
            yield from self._release(frames.performer, slot)
        if slot != REFUSED:
            yield from self._sent_on(slot, frames)

    def _release(self, ident: str, slot: str | None) -> Iterator[Item]:
        for frames in self._held.pop(ident, ()):
            if slot:
                yield from self._sent_on(slot, frames)

    def _sent_on(self, slot: str, frames: Frames) -> Iterator[Item]:
        latest = self._latest
        if latest is not None and latest.performer != frames.performer and self._slots.chooses:
            # Frames kept back while another person had the only slot belong to no performer.
            begin = int(frames.times.searchsorted(latest.times[-1], "right"))
            if begin == len(frames):
                return
            frames = part(frames, begin, len(frames))
        self._latest = frames
        meta = self._metas.get(frames.performer)
        if meta is not None:
            sent = self._sent.get(slot)
            if sent is None or (sent is not meta and sent != msgspec.structs.replace(meta, performer=slot)):
                sent = self._sent[slot] = msgspec.structs.replace(meta, performer=slot)
                yield sent
        self._left.pop(slot, None)
        self._begun.add(slot)
        if not self._shifts.get(frames.performer):
            self._straight[frames.performer] = slot
            if len(self._straight) > _IDS:
                del self._straight[next(iter(self._straight))]
        yield msgspec.structs.replace(frames, performer=slot)

    def _report(self) -> Iterator[Item]:
        """Pass on, and log, the changes."""
        self._straight.clear()
        for change in self._slots.changes():
            if change.how == "refused":
                self._logged += 1
                if self._logged <= _MOST_LOGGED:
                    names = ", ".join(self._slots.names)
                    _log.warning(
                        "%s: %s is refused, there are as many as wanted: %s",
                        self.name,
                        shown(change.id),
                        names,
                    )
                continue
            known = self._occupants.get(change.slot) == change.id and not change.another
            self._occupants[change.slot] = change.id
            # The same after a pause, which at 3 Hz is every frame, is nothing to report.
            _log.log(logging.DEBUG if known else logging.INFO, "%s: %s", self.name, in_words(change))
            another = change.another or change.slot in self._anew
            self._anew.discard(change.slot)
            if another and change.slot in self._begun:
                yield Departure(change.slot, f"{shown(change.id)} instead")
            yield Occupant(change.slot, change.id, another)

    def _on_one_clock(self, frames: Frames) -> Frames:
        """Return frames of a live source on the clock of the others, if the id has one of its own."""
        ident = frames.performer
        shift = self._shifts.get(ident)
        if self.live and shift != 0 and self._now > -np.inf:
            silence = time.monotonic() - self._arrived
            ahead = float(frames.times[0]) + (shift or 0.0) - self._now
            last = float(frames.times[-1]) + (shift or 0.0)
            if shift is None:  # a sender that was started later or earlier, or --fps
                is_off = last < self._now - BACK or ahead > silence + _BEHIND
                is_off = is_off and not self._slots.knows(ident)
            else:
                is_off = self._slots.went_back(ident, last)  # it was started anew
            if is_off:
                meta = self._metas.get(ident)
                step = 1 / meta.fps if meta is not None and meta.fps else _STEP
                shift = (shift or 0.0) + max(step, silence) - ahead
                self._slots.separate(ident)
            self._shifts[ident] = shift or 0.0
            if len(self._shifts) > _IDS:
                self._shifts.popitem(last=False)
        return msgspec.structs.replace(frames, times=frames.times + shift) if shift else frames

    def _unused(self, item: Item) -> Item:
        """Return an item without the frames that a former run used."""
        left = self._skip.get(item.performer, 0) if isinstance(item, Frames) else 0
        if not left or not isinstance(item, Frames):
            return item
        skipped = min(left, len(item))
        self._skip[item.performer] = left - skipped
        return part(item, skipped, len(item)) if skipped < len(item) else None


def shown(ident: str) -> str:
    """Return an id in words: `p7`, as performers with a number are called, is id 7.

    Example:
        >>> shown("p7"), shown("anna")
        ('id 7', 'id anna')
    """
    return f"id {ident[1:]}" if ident[:1] == "p" and ident[1:].isdecimal() else f"id {ident}"


def in_words(change: Change) -> str:
    """Return the changes, in words."""
    text = f"{change.slot} is {shown(change.id)}"
    match change.how:
        case "place":
            return f"{text}, by place, after {change.away:.1f} s"
        case "lengths":
            return f"{text}, by the lengths of bones, after {change.away:.0f} s"
        case "swap":
            return f"{text}: the tracker has exchanged ids"
        case "chosen":
            return f"{text} now"
        case "asked":
            return f"{text}, as asked for"
    return f"{text}, another person" if change.another else text
