"""Limbs of one performer: a segmenter for each, all fed from the frames of the body."""

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mossar_stream.engine import engine
from mossar_stream.engine.curve_state import CurveState
from mossar_stream.engine.limb_rows import SILENT, LimbRows
from mossar_stream.engine.middle import set_middle
from mossar_stream.engine.pool import Row
from mossar_stream.errors import SnapshotError
from mossar_stream.moves.groups import MEAN, groups_of
from mossar_stream.settings import LevelName, Settings
from mossar_stream.skeleton import Skeleton


class LimbSteps(Protocol):
    """What a limb does as its body does."""

    def follow(self, settings: Settings, level: LevelName | float) -> None: ...  # noqa: D102


class LimbSegmenter(Protocol):
    """What is needed of the segmenter of a limb; `Segmenter` is one."""

    performer: str

    @property
    def row(self) -> Row: ...  # noqa: D102
    @property
    def steps(self) -> LimbSteps: ...  # noqa: D102
    @property
    def skeleton(self) -> Skeleton: ...  # noqa: D102
    @property
    def state(self) -> CurveState | None: ...  # noqa: D102
    @property
    def state_bytes(self) -> int: ...  # noqa: D102
    def carry_on(self, counts: Mapping[str, int]) -> None: ...  # noqa: D102
    def release(self) -> None: ...  # noqa: D102
    def snapshot(self) -> bytes: ...  # noqa: D102


NewSegmenter = Callable[[Skeleton, Settings, str], LimbSegmenter]


def settings_of_limbs(settings: Settings) -> Settings:
    """Return the settings by which limbs are segmented, given those of the body."""
    return settings.replace(limbs=False, phase=False, steps=False, center="root")


class Limbs:
    """The limbs of one performer.

    A limb's take opens and ends with the body's. Limbs process the frames that the body processes, after it, and are not
    asked about those that come too soon for it. Their events are added to what is pending of the body.

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
        order = [joint for limb in self._groups for joint in limb.joints]
        self._order = np.array(order, np.intp)  # (K,) joints of all limbs, one limb after the other
        self._means = [k for k, joint in enumerate(order) if joint == MEAN]  # which of them are the mean
        self._lay()

    def _lay(self) -> None:
        """Bring the rows of all limbs together, which is done again when one needed more room."""
        rows = LimbRows(self._body, self._own, [limb.joints for limb in self._groups])
        rows.warm_up(self._body)
        self._rows = rows
        # Whether all limbs are in takes that go on, and nothing waits for their next frame;
        self._goes_on = False
        self._taken = 0.0  # if so: when the body, and so they, processed the last frame, s,
        self._spacing = 0.0  # and by how much later the next one comes at least, s

    @property
    def _own(self) -> list[Row]:
        """The row of each limb."""
        return [segmenter.row for segmenter in self._segmenters]

    @property
    def names(self) -> tuple[str, ...]:
        """Their channels."""
        return tuple(limb.name for limb in self._groups)

    @property
    def segmenters(self) -> dict[str, LimbSegmenter]:
        """The segmenter of each; its events say nothing of the limb."""
        self._catch_up()
        return dict(zip(self.names, self._segmenters, strict=True))

    def hold(self, time: float) -> bool:
        """Tell whether nothing comes of a frame of a take that goes on, at this time, s: it comes too soon."""
        return self._goes_on and -self._spacing < time - self._taken < self._spacing

    def stop(self) -> None:
        """Ask all limbs about the next frame, and let them know of those before it."""
        self._goes_on = False
        self._catch_up()
        for row in self._own:
            self._adopt(row)

    def _catch_up(self) -> None:
        """Let the clocks of the limbs show what the body's shows."""
        body = self._body.clock
        for row in self._own:
            clock = row.clock
            if clock["open"]:
                clock["used_frame"], clock["time"] = body["used_frame"], body["time"]
                if body["open"]:
                    clock["next_frame"] = body["next_frame"]

    def _adopt(self, row: Row) -> None:
        """Let a limb know what is counted of its body, after each look at that."""
        own, body = row.adopted, self._body.counted
        if not len(own) or not len(body):
            return  # or the body counts no longer, and the settings of the limb follow
        # Field by field: of whole records numpy compares types in Python, and reports an exception in there as a TypeError.
        if own["looked"][0] != body["looked"][0] or own["origin"][0] != body["origin"][0]:
            row.adopt_repetitions(body)

    def take(self, position: NDArray[np.float32], time: NDArray[np.float64]) -> bool:
        """Process one frame of a take that goes on, of the body and of all limbs, at once.

        Args:
            position: (1, J, 3) m.
            time: (1,) s.

        Returns:
            Whether that was possible; if not, nothing is done: the body must process the frame, then `push`.
        """
        if not self._goes_on:
            return False
        done = self._rows.advance(position, time, self._body)
        self._taken = float(self._body.taken_time[0])
        if 0 <= done < len(self._segmenters):
            self._push_apart(time, done)
        return done >= SILENT

    def push(self, positions: NDArray[np.float32], time: NDArray[np.float64]) -> None:
        """Process the frame that the body was given, limb by limb, if the body did not pass it over.

        Args:
            positions: (1, J, 3) m.
            time: (1,) s.
        """
        if not self._rows.holds(self._body, self._own):
            self._lay()
        if self._body.clock["open"] and self._body.taken_time[0] == time[0]:
            np.take(positions, self._order, axis=1, out=self._rows.frame, mode="wrap")
            for k in self._means:
                set_middle(self._body.memory, self._rows.frame[0, k])
            self._push_apart(time)

    def _push_apart(self, time: NDArray[np.float64], begin: int = 0) -> None:
        """Process a frame of each limb, from `begin` on, one after the other."""
        body = self._body
        for row, view in zip(self._own[begin:], self._rows.views[begin:], strict=True):
            clock = row.clock
            if clock["open"]:
                clock["time"] = max(clock["time"], body.clock["time"] - 0.5 * body.plan.given.max_pause)
            else:
                clock["take"] = body.clock["take"]
            clock["next_frame"] = body.clock["used_frame"]
            self._adopt(row)
            engine.process_short(row, view, time)
        if not self._rows.holds(body, self._own):
            self._lay()
        self._goes_on = all(row.is_live and not row.is_level_new for row in (body, *self._own))
        self._taken, self._spacing = float(body.taken_time[0]), body.plan.spacing

    def end_take(self) -> None:
        """End the take of all limbs, as the body's has ended."""
        self.stop()
        for row in self._own:
            engine.close_take(row)
            engine.report_end(row, "")

    def forget_ranges(self) -> None:
        """Forget the ranges of all limbs, after their takes ended."""
        for row in self._own:
            row.forget_range()

    def apply_level(self) -> None:
        """Let a level that moved act."""
        for row in self._own:
            engine.apply_level(row)

    def follow(self, settings: Settings, level: LevelName | float) -> None:
        """Go on with other settings of the performer, which leave the limbs as they are; no take of theirs is ended by them alone."""
        self.stop()
        own = settings_of_limbs(settings)
        for segmenter in self._segmenters:
            segmenter.steps.follow(own, level)
        if not self._rows.holds(self._body, self._own):
            self._lay()

    def mend(self) -> None:
        """Finish what an exception cut short; see `engine.mend`."""
        for row in self._own:
            engine.mend(row)
        if not self._rows.holds(self._body, self._own):
            self._lay()
        self.stop()

    def carry_on(self, counts: Mapping[str, int]) -> None:
        """Number takes on from those of the body; see `Segmenter.counts`."""
        for segmenter in self._segmenters:
            segmenter.carry_on(counts)

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
