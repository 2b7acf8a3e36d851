"""Limbs of one performer: a segmenter for each, all fed from the frames of the body."""

import functools
from collections.abc import Callable, Mapping
from typing import Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.engine import engine
from mossar_stream.engine.curve_state import CurveState
from mossar_stream.engine.limb_rows import SILENT, LimbRows
from mossar_stream.engine.pool import Row
from mossar_stream.errors import SnapshotError
from mossar_stream.events import (
    BODY,
    ActivityEvent,
    Event,
    KeyFrameEvent,
    RepetitionEvent,
    SegmentEvent,
    StreamEvent,
)
from mossar_stream.moves.groups import MEAN, groups_of, leading_limb, limbs_by_joint, mean_of
from mossar_stream.settings import LevelName, Settings
from mossar_stream.skeleton import Skeleton


class LimbSegmenter(Protocol):
    """What is needed of the segmenter of a limb; `Segmenter` is one."""

    performer: str
    level: LevelName | float

    @property
    def row(self) -> Row: ...  # noqa: D102
    @property
    def skeleton(self) -> Skeleton: ...  # noqa: D102
    @property
    def state(self) -> CurveState | None: ...  # noqa: D102
    @property
    def state_bytes(self) -> int: ...  # noqa: D102
    def change(self, **changes: object) -> list[Event]: ...  # noqa: D102
    def carry_on(self, counts: Mapping[str, int]) -> None: ...  # noqa: D102
    def end_take(self) -> list[Event]: ...  # noqa: D102
    def reset(self) -> list[Event]: ...  # noqa: D102
    def release(self) -> None: ...  # noqa: D102
    def snapshot(self) -> bytes: ...  # noqa: D102


KNOWN_LEADERS = 256  # sets of joints whose limb is remembered
NewSegmenter = Callable[[Skeleton, Settings, str], LimbSegmenter]


def settings_of_limbs(settings: Settings) -> Settings:
    """Return the settings by which limbs are segmented, given those of the body."""
    return settings.replace(limbs=False, phase=False, steps=False, center="root")


class Limbs:
    """The limbs of one performer.

    A limb's take opens and ends with the body's, because both see the same times. While it goes on, limbs take in what
    the body takes in, and are not asked about the frames that come too soon for it.

    Args:
        body: The performer's row.
        settings: Of the performer; `limbs` says which.
        new_segmenter: Returns a segmenter for a limb's skeleton with settings, and its channel.

    Raises:
        FrameError: See `groups_of`.
    """

    def __init__(self, body: Row, settings: Settings, new_segmenter: NewSegmenter) -> None:
        self._body = body
        self._groups = groups_of(body.plan.skeleton, settings.limbs)
        own = settings_of_limbs(settings)
        self._segmenters = [new_segmenter(limb.skeleton, own, limb.name) for limb in self._groups]
        by_joint = limbs_by_joint(self._groups)
        # The same joints lead again and again, and a segment is told of several times.
        self._leading = functools.lru_cache(KNOWN_LEADERS)(lambda joints: leading_limb(joints, by_joint))
        order = [joint for limb in self._groups for joint in limb.joints]
        self._order = np.array(order, np.intp)  # (K,) joints of all limbs, one limb after the other
        self._means = [k for k, joint in enumerate(order) if joint == MEAN]  # which of them are the mean
        self._lay()

    def _lay(self) -> None:
        """Bring the rows of all limbs together, which is done again when one needed more room."""
        self._rows = LimbRows(
            self._body,
            [segmenter.row for segmenter in self._segmenters],
            [limb.joints for limb in self._groups],
        )
        self._rows.warm_up(self._body)
        # Whether all limbs are in takes that go on, and nothing waits for their next frame;
        self._goes_on = False
        self._taken = 0.0  # if so: when the body, and so they, took the last frame in, s,
        self._spacing = 0.0  # and by how much later the next one comes at least, s

    @property
    def names(self) -> tuple[str, ...]:
        """Their channels."""
        return tuple(limb.name for limb in self._groups)

    @property
    def segmenters(self) -> dict[str, LimbSegmenter]:
        """The segmenter of each; its events say nothing of the limb."""
        self._catch_up()
        return dict(zip(self.names, self._segmenters, strict=True))

    def hold(self, _position: NDArray[np.float32], time: float) -> bool:
        """Tell whether nothing comes of a frame of a take that goes on, at this time, s: it comes too soon.

        While nobody is seen, the take may end with any frame.
        """
        if not self._goes_on or not -self._spacing < time - self._taken < self._spacing:
            return False
        return bool(self._body.present[0])

    def stop(self) -> None:
        """Ask all limbs about the next frame, and let them know of those before it: a take may begin with it."""
        self._goes_on = False
        self._catch_up()
        for segmenter in self._segmenters:
            segmenter.row.adopt_repetitions(self._body.counted)

    def _catch_up(self) -> None:
        """Let the clocks of the limbs show what the body's shows."""
        body = self._body.clock
        for segmenter in self._segmenters:
            clock = segmenter.row.clock
            if clock["open"]:
                clock["used_frame"], clock["time"] = body["used_frame"], body["time"]
                if body["open"]:
                    clock["next_frame"] = body["next_frame"]

    def take(self, position: NDArray[np.float32], time: NDArray[np.float64]) -> list[Event] | None:
        """Take one frame of a take that goes on in, of the body and of all limbs, at once.

        Args:
            position: (1, J, 3) m.
            time: (1,) s.

        Returns:
            The events; None if that cannot be: then nothing is done, the body must take it in, then `push`.
        """
        if not self._goes_on:
            return None
        if self._means and not self.hold(position, float(time[0])):
            self._rows.frame[0, self._means] = mean_of(position)
        try:
            done, events = self._rows.advance(position, time, self._body)
        except BaseException:  # the next frame finds out what waits
            self._goes_on = False
            raise
        self._taken = float(self._body.taken_time[0])
        if done < SILENT:
            self._body.pending += events
            return None
        if events:
            events = self.lead(events)
        if 0 <= done < len(self._segmenters):
            events += self._push_apart(time, None, done)
        return events

    def push(
        self, positions: NDArray[np.float32], time: NDArray[np.float64], first_frame: int | None
    ) -> list[Event]:
        """Take one frame of the body in, limb by limb; `stop` came before it, then the body took it in.

        Args:
            positions: (1, J, 3) m.
            time: (1,) s.
            first_frame: Number of the frame; None to count on.
        """
        np.take(positions, self._order, axis=1, out=self._rows.frame, mode="wrap")
        if self._means:
            self._rows.frame[0, self._means] = mean_of(positions)
        return self._push_apart(time, first_frame)

    def _push_apart(self, time: NDArray[np.float64], first_frame: int | None, begin: int = 0) -> list[Event]:
        """Take a frame of each limb in, from `begin` on, one after the other."""
        events: list[Event] = []
        rows = [segmenter.row for segmenter in self._segmenters]
        if not self._body.clock["open"]:  # nobody is there: the body's take has ended, or not begun
            for row in rows:
                events += _told(engine.end_take(row))
            self.join(int(self._body.clock["take"]), int(self._body.clock["next_frame"]))
            self._goes_on = False
            return events
        # Their takes begin with a frame that the body takes in, or they would take in others than the body from then on.
        if not rows[0].is_live and self._body.taken_time[0] != time[0]:
            self.join(int(self._body.clock["take"]), int(self._body.clock["next_frame"]))
            return events
        for row, view in zip(rows[begin:], self._rows.views[begin:], strict=True):
            if row.clock["take"] == self._body.clock["take"]:  # else that of the body began with this frame
                row.adopt_repetitions(self._body.counted)
            events += _told(engine.push_short(row, view, time, first_frame))
        if not self._rows.holds(self._body, rows):
            self._lay()
        whole = self._body, *rows
        self._goes_on = all(row.is_live and not row.is_level_new and not row.pending for row in whole)
        self._taken, self._spacing = float(self._body.taken_time[0]), self._body.plan.spacing
        return events

    def lead(self, events: list[Event]) -> list[Event]:
        """Return events, the segments of the body among them with the limb that led."""
        return [
            msgspec.structs.replace(event, limb=self._leading(event.active_joints))
            if isinstance(event, SegmentEvent) and event.channel == BODY
            else event
            for event in events
        ]

    def end_take(self) -> list[Event]:
        """End the take of all limbs."""
        self.stop()
        return [event for own in self._segmenters for event in _told(own.end_take())]

    def reset(self) -> list[Event]:
        """End the take of all limbs, and forget their ranges."""
        self.stop()
        return [event for own in self._segmenters for event in _told(own.reset())]

    def set_level(self, level: LevelName | float) -> None:
        """Move the level of all limbs."""
        self.stop()
        for segmenter in self._segmenters:
            segmenter.level = level

    def change(self, settings: Settings) -> None:
        """Go on with other settings of the performer, which leave the limbs as they are; no take of theirs is ended by them alone."""
        self.stop()
        wanted = msgspec.structs.asdict(settings_of_limbs(settings))
        for segmenter in self._segmenters:
            segmenter.change(**wanted)
        if not self._rows.holds(self._body, [segmenter.row for segmenter in self._segmenters]):
            self._lay()

    def carry_on(self, counts: Mapping[str, int]) -> None:
        """Number takes on from those of the body; see `Segmenter.counts`."""
        for segmenter in self._segmenters:
            segmenter.carry_on(counts)

    def join(self, take: int, frame: int) -> None:
        """Come in while a take of the body is open.

        Args:
            take: Its number.
            frame: Number of the next frame.
        """
        for segmenter in self._segmenters:
            segmenter.row.clock["take"] = take  # no take is open
            segmenter.row.clock["next_frame"] = frame

    def release(self) -> None:
        """Give the rows back that the state lies in."""
        for segmenter in self._segmenters:
            segmenter.release()

    def snapshot(self) -> tuple[bytes, ...]:
        """Return what all limbs know."""
        self.stop()
        return tuple(segmenter.snapshot() for segmenter in self._segmenters)

    def restore(self, blobs: tuple[bytes, ...], restored: Callable[[bytes, str], LimbSegmenter]) -> None:
        """Go on where the limbs of a snapshot were.

        Args:
            blobs: One snapshot for each limb.
            restored: Returns the segmenter of a snapshot of a channel.

        Raises:
            SnapshotError: If they are damaged or not those of these limbs.
        """
        if len(blobs) != len(self._segmenters):
            raise SnapshotError("the snapshot's limbs are not those of its settings")
        found = [restored(blob, name) for blob, name in zip(blobs, self.names, strict=True)]
        same = all(
            (one.skeleton, one.performer, one.row.plan.given)
            == (own.skeleton, own.performer, own.row.plan.given)
            for one, own in zip(found, self._segmenters, strict=True)
        )
        if not same:
            raise SnapshotError("the snapshot's limbs are not those of its settings")
        self._segmenters = found
        self._lay()


def _told(events: list[Event]) -> list[Event]:
    """Return what is said of a limb: its key frames, segments, activity and repetitions."""
    return [
        event
        for event in events
        if isinstance(event, KeyFrameEvent | SegmentEvent | ActivityEvent | RepetitionEvent)
    ]


def together(body: list[Event], limbs: list[Event]) -> list[Event]:
    """Return the events of one frame: the body's, then the limbs'.

    Where a take ends, what the limbs say of it stands before the word that it ended.
    """
    ends = next((k for k, e in enumerate(body) if isinstance(e, StreamEvent) and e.event == "ended"), None)
    if ends is None or not limbs:
        return [*body, *limbs]
    old = [event for event in limbs if _take(event) == _take(body[ends])]
    new = [event for event in limbs if _take(event) != _take(body[ends])]
    return [*body[:ends], *old, *body[ends:], *new]


def _take(event: Event) -> int | None:
    return getattr(event, "take", None)
