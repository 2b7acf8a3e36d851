"""Counter: the repetitions of one performer, frames in, events out."""

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.errors import SnapshotError
from mossar_stream.events import PhaseEvent, RepetitionEvent, RepetitionStatus
from mossar_stream.repetitions.counting import CHANGED, NOTHING, TAKE_ENDS, count_frames, count_rest
from mossar_stream.repetitions.sampling import is_wanted
from mossar_stream.repetitions.state import CYCLES, HEADER, RATE, STRIDE, length, start
from mossar_stream.skeleton import Skeleton

HELD = 64  # frames
INTERVALS = 3  # cycles over which the period is measured
LONGEST_SILENCE = 1.5  # cycles without a new one, after which there is no phase
FARTHEST = 2**48  # samples; no take is as long

__all__ = ["CHANGED", "NOTHING", "TAKE_ENDS", "RepetitionCounter", "count_recording"]


class _Content(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    take: int
    told: int
    phase_told: tuple[float, bool]
    revisions: dict[int, int]
    header: bytes
    memory: bytes


def count_recording(
    skeleton: Skeleton, positions: NDArray[np.float32], times: NDArray[np.float64], max_pause: float
) -> list[RepetitionEvent]:
    """Return the repetitions of a whole recording, as what was said of each at last.

    Args:
        skeleton: J joints.
        positions: (n, J, 3) m.
        times: (n,) s.
        max_pause: See `RepetitionCounter`; what is repeated after a pause is numbered anew.
    """
    counter = RepetitionCounter(skeleton, "p1", 0, max_pause)
    latest: dict[str, RepetitionEvent] = {}
    used, stop = 0, CHANGED
    while stop != NOTHING:
        used, stop = counter.follow(positions, times, used)
        news = counter.end_take() if stop in {NOTHING, TAKE_ENDS} else counter.news()
        latest.update((event.id, event) for event in news)
    return [event for event in latest.values() if event.status == "counted"]


class RepetitionCounter:
    """Counts how often a movement is repeated; all state has a fixed size.

    Args:
        skeleton: The performer's joints.
        performer: Name that events carry.
        take: Number of the take that begins with the next frame.
        max_pause: s without frames, or back in time, after which another take begins.
    """

    def __init__(self, skeleton: Skeleton, performer: str, take: int, max_pause: float) -> None:
        self.performer = performer
        self.take = take
        self._names = skeleton.names
        self._header = np.zeros(1, HEADER)
        self._header["joints"], self._header["root"] = len(skeleton), max(skeleton.root, 0)
        self._header["max_pause"] = max_pause
        self._memory = np.zeros(length(len(skeleton)), np.float32)
        self._row = self._header[0]
        self._positions = np.zeros((HELD, len(skeleton), 3), np.float32)
        self._times = np.zeros(HELD)
        self._last_held = self._due = -math.inf  # s
        self._origin = 0.0  # s, of the take
        self._sample = self._frames = 0  # number of the open sample, and frames that it has
        self._begin()

    def _begin(self) -> None:
        self._told = 0
        self._phase_told = (-math.inf, False)  # s, of which frame, and whether it had one
        self._revisions: dict[
            int, int
        ] = {}  # messages by number of the cycle, for those that may still change
        self._held = 0
        start(self._header, self._memory)
        self._set_due()

    @property
    def total(self) -> int:
        """Repetitions counted in this take."""
        row = self._row
        return int(row["dropped"] + row["cycles"]) if row["clear"] else 0

    def follow(
        self, positions: NDArray[np.float32], times: NDArray[np.float64], begin: int = 0
    ) -> tuple[int, int]:
        """Take frames in, up to and with the first that changes what is counted.

        Args:
            positions: (n, J, 3) m, NaN where a joint is missing.
            times: (n,) s.
            begin: The first frame to take.

        Returns:
            The first frame not taken, and one of `NOTHING`, `CHANGED` and `TAKE_ENDS`.
        """
        self._flush()
        used, stop = count_frames(self._header, self._memory, positions, times, begin)
        self._set_due()
        return used, stop

    def hold(self, position: NDArray[np.float32], time: float) -> bool:
        """Keep one frame for later if no look is due with it, which is quicker than a kernel's call.

        Args:
            position: (J, 3) or (1, J, 3) m; copied.
            time: s.

        Returns:
            Whether it was kept; `follow` must take it otherwise.
        """
        held = self._held
        if held == HELD or not self._last_held < time < self._due:
            return False
        sample = int((time - self._origin) * RATE + 1e-6)
        if sample != self._sample:
            self._sample, self._frames = sample, 0
        if not is_wanted(self._origin, sample, self._frames, time):
            self._last_held = time
            return True
        self._frames += 1
        self._positions[held] = position
        self._times[held] = self._last_held = time
        self._held = held + 1
        return True

    def _flush(self) -> None:
        """Count the frames that are held; none of them changes anything."""
        held, self._held = self._held, 0
        if held:
            count_frames(self._header, self._memory, self._positions[:held], self._times[:held], 0)
        self._row["latest"] = max(self._row["latest"], self._last_held)

    def _set_due(self) -> None:
        """Note from when on frames must go to the kernel: a look may be due, or the take may end."""
        row = self._header[0]
        self._last_held = float(row["latest"])
        self._origin, self._sample = float(row["origin"]), int(row["open"])
        self._frames = int(row["frames"])
        look = float(row["origin"]) + (float(row["looked"]) + STRIDE - 0.01) / RATE
        self._due = min(look, self._last_held + float(row["max_pause"])) if row["begun"] else -math.inf

    def news(self) -> list[RepetitionEvent]:
        """Return what to say after `CHANGED`: cycles withdrawn, then those that are new or changed."""
        row = self._row
        total, dropped = self.total, int(row["dropped"])
        events = [self._event(number, "withdrawn") for number in range(self._told, total, -1)]
        events += [
            self._event(number, "counted") for number in range(dropped + int(row["changed"]) + 1, total + 1)
        ]
        self._told = total
        for number in [number for number in self._revisions if number <= dropped]:
            del self._revisions[number]
        return events

    def end_take(self) -> list[RepetitionEvent]:
        """Return what the last frames change; the next frame begins a new take."""
        self._flush()
        events = self.news() if count_rest(self._header, self._memory) else []
        self.take += int(self._row["begun"])
        self._begin()
        return events

    def phase(self) -> float | None:
        """Return where in the cycle the latest frame is, 0 to 1 from where cycles begin; None out of a bout."""
        self._flush()
        row, cycles = self._row, int(self._row["cycles"])
        period = self._period(cycles - 1) if cycles and row["clear"] else None
        if period is None:
            return None
        last = row["cycle"][cycles - 1]
        now = (float(row["latest"]) - float(row["origin"])) * RATE
        since = now - float(last["end"]) - 0.5
        return None if since > LONGEST_SILENCE * period * RATE else (since / (period * RATE)) % 1.0

    def phase_news(self) -> list[PhaseEvent]:
        """Return the phase of the latest frame, unless it was told, or nothing repeats and that was told."""
        phase = self.phase()
        time = float(self._row["latest"])
        before, self._phase_told = self._phase_told, (time, phase is not None)
        if time == before[0] or (phase is None and not before[1]):
            return []
        who = (self.performer, self.take)
        return [PhaseEvent(performer=who[0], take=who[1], channel="body", time=time, phase=phase)]

    def _period(self, place: int) -> float | None:
        """Return the duration of a cycle, s, over the last ones of its bout; None for the first."""
        cycle = self._row["cycle"]
        back = min(int(cycle[place]["count"]) - 1, INTERVALS, place)
        if back < 1:
            return None
        first, last = cycle[place - back], cycle[place]
        out, returned = last["out"] - first["out"], last["back"] - first["back"]
        return max(float(out + returned) / (2 * back * RATE), 1 / RATE)

    def _begin_of(self, place: int) -> float:
        """Return where a cycle begins, samples; in a bout between passing half way back and half way out again."""
        cycle = self._row["cycle"][place]
        if place == 0 or cycle["count"] == 1:
            # Where it rests the extreme is anywhere: movements begin as long before half way as they end behind it.
            return float(max(cycle["start"], 2 * cycle["out"] - cycle["far"])) + 0.5
        return float(self._row["cycle"][place - 1]["back"] + cycle["out"] + 1) / 2

    def _end_of(self, place: int) -> float:
        if place + 1 < self._row["cycles"] and self._row["cycle"][place + 1]["count"] > 1:
            return self._begin_of(place + 1)
        cycle = self._row["cycle"][place]
        return float(min(cycle["end"], 2 * cycle["back"] - cycle["far"])) + 0.5

    def _event(self, number: int, status: RepetitionStatus) -> RepetitionEvent:
        row = self._row
        revision = self._revisions[number] = self._revisions.get(number, 0) + 1
        counted = status == "counted"
        place = number - int(row["dropped"]) - 1 if counted else max(int(row["cycles"]) - 1, 0)
        cycle = row["cycle"][place]
        period = self._period(place) if counted else None
        origin = float(row["origin"])
        return RepetitionEvent(
            performer=self.performer,
            id=f"{self.performer}/{self.take}/r{number}",
            rev=revision,
            status=status,
            take=self.take,
            channel="body",
            count=int(cycle["count"]) if counted else 0,
            total=number if counted else number - 1,
            period=period,
            tempo=None if period is None else 60.0 / period,
            start=origin + self._begin_of(place) / RATE if counted else None,
            end=origin + self._end_of(place) / RATE if counted else None,
            amplitude=float(cycle["amplitude"]) if counted else None,
            joint=self._names[int(cycle["joint"])] if counted else None,
            decided_time=float(row["latest"]),
        )

    def snapshot(self) -> bytes:
        """Return everything the counter knows."""
        self._flush()
        content = _Content(
            self.take,
            self._told,
            self._phase_told,
            self._revisions,
            self._header.tobytes(),
            self._memory.tobytes(),
        )
        return msgspec.msgpack.encode(content)

    def restore(self, blob: bytes) -> None:
        """Go on where the counter that made `blob` was.

        Raises:
            SnapshotError: If the bytes do not fit this skeleton or contradict themselves.
        """
        try:
            content = msgspec.msgpack.decode(blob, type=_Content)
        except msgspec.MsgspecError as error:
            raise SnapshotError(f"the snapshot's repetitions cannot be read: {error}") from None
        if len(content.header) != HEADER.itemsize or len(content.memory) != self._memory.nbytes:
            raise SnapshotError("the snapshot's repetitions are of another size")
        header = np.frombuffer(content.header, HEADER)
        if not self._is_sound(header[0]):
            raise SnapshotError("the snapshot's repetitions contradict themselves")
        self.take, self._told, self._revisions = content.take, content.told, dict(content.revisions)
        self._phase_told = content.phase_told
        self._header[:] = header
        self._memory[:] = np.frombuffer(content.memory, np.float32)
        self._set_due()

    def _is_sound(self, row: np.void) -> bool:
        """Return whether every number that kernels use as an index or count lies where it must."""
        same = all(row[name] == self._row[name] for name in ("joints", "root", "max_pause"))
        counts = [int(row[name]) for name in ("frames", "open", "looked", "dropped", "cycles")]
        cycles = row["cycle"]
        places = np.concatenate([cycles["start"], cycles["far"], cycles["end"], cycles["count"]])
        return bool(
            same
            and all(0 <= count < FARTHEST for count in counts)
            and row["cycles"] <= CYCLES
            and row["looked"] <= row["open"]
            and 0 <= row["changed"] + 1 <= CYCLES + 1
            and row["clear"] in (0, 1)
            and row["begun"] in (0, 1)
            and np.isfinite(row["origin"])
            and np.isfinite(row["latest"])
            and np.all(np.abs(places) < FARTHEST)
            and np.all((cycles["joint"] >= 0) & (cycles["joint"] < row["joints"]))
        )
