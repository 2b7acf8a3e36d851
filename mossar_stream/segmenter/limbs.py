"""Limbs of one performer: a row for each, which the loop steps after that of the body."""

from collections.abc import Callable, Mapping

from mossar_stream.core import engine
from mossar_stream.core.curve_state import CurveState, curve_state
from mossar_stream.core.kernels import RECORDS
from mossar_stream.core.plan import Plan
from mossar_stream.core.pool import Row, restored_row
from mossar_stream.core.snapshot import Following, pack_snapshot, unpack_snapshot
from mossar_stream.errors import SnapshotError
from mossar_stream.events import BODY, Event
from mossar_stream.moves.groups import groups_of
from mossar_stream.settings import LevelName, Settings

NewRow = Callable[[Plan, list[Event]], Row]  # of a plan, and where its events wait


def settings_of_limbs(settings: Settings) -> Settings:
    """Return the settings by which limbs are segmented, given those of the body."""
    return settings.replace(limbs=False, phase=False, steps=False, center="root")


def plans_of_limbs(plan: Plan) -> list[Plan]:
    """Return the plans of the limbs that the plan of a body calls for.

    Raises:
        FrameError: See `groups_of`.
    """
    own = settings_of_limbs(plan.user_settings)
    groups = groups_of(plan.skeleton, plan.user_settings.limbs) if plan.channel == BODY else ()
    return [Plan(limb.skeleton, own, plan.fps, channel=limb.name) for limb in groups]


def bytes_with_limbs(plan: Plan) -> int:
    """Return the bytes of the rows of a body and of its limbs."""
    return plan.row_bytes + sum(limb.row_bytes for limb in plans_of_limbs(plan))


class Limbs:
    """The limbs of one performer.

    A limb's take opens and ends with the body's. Limbs process the frames that the body processes, after it, and are not
    asked about those that come too soon for it. Their events are added to what is pending of the body.

    Args:
        body: The performer's row.
        level: As it is now.
        new_row: Returns a row for a limb.

    Attributes:
        rows: Of the limbs.
        joints: Of each limb: which joints of the performer they are.

    Raises:
        FrameError: See `groups_of`.
    """

    def __init__(self, body: Row, level: LevelName | float, new_row: NewRow) -> None:
        self._body, self._level = body, level
        self._groups = groups_of(body.plan.skeleton, body.plan.user_settings.limbs)
        self.rows = [new_row(plan, body.pending) for plan in plans_of_limbs(body.plan)]
        self.joints = [limb.joints for limb in self._groups]

    @property
    def names(self) -> tuple[str, ...]:
        """Their channels."""
        return tuple(limb.name for limb in self._groups)

    @property
    def states(self) -> dict[str, CurveState | None]:
        """The velocity curve of each at the last frame; None before the first."""
        self.catch_up()
        shown = (curve_state(row.memory, row.plan) if row.clock["open"] else None for row in self.rows)
        return dict(zip(self.names, shown, strict=True))

    @property
    def bytes_taken(self) -> int:
        """Bytes of their state."""
        return sum(row.plan.row_bytes for row in self.rows)

    def catch_up(self) -> None:
        """Let the clocks of the limbs show what the body's shows, and let them know what is counted of it."""
        body = self._body
        for row in self.rows:
            clock = row.clock
            if clock["open"]:
                clock["used_frame"], clock["time"] = body.clock["used_frame"], body.clock["time"]
                if body.clock["open"]:
                    clock["next_frame"] = body.clock["next_frame"]
            own, counted = row.adopted, body.periods
            if not len(own) or not len(counted):
                continue  # or the body counts no longer, and the settings of the limb follow
            # Field by field: of whole records numpy compares types in Python, and reports an exception in there as a TypeError.
            if own["analysed"][0] != counted["analysed"][0] or own["origin"][0] != counted["origin"][0]:
                row.adopt_periods(counted)

    def end_take(self) -> None:
        """End the take of all limbs, as the body's has ended."""
        self.catch_up()
        body = self._body.clock
        for row in self.rows:  # their last segments end with the last frame in which the body was seen
            row.clock["shown_frame"], row.clock["shown_time"] = body["shown_frame"], body["shown_time"]
            engine.close_take(row)
            engine.report_end(row, "")

    def forget_ranges(self) -> None:
        """Forget the ranges of all limbs, after their takes ended."""
        for row in self.rows:
            row.forget_range()

    def apply_level(self) -> None:
        """Let a level that moved act."""
        for row in self.rows:
            engine.apply_level(row)

    def follow(self, level: LevelName | float) -> None:
        """Go on with the settings of the body as they are now, which leave the limbs as they are, and with its level."""
        self.catch_up()
        self._level = level
        own = settings_of_limbs(self._body.plan.user_settings)
        for row in self.rows:
            before = row.plan
            if own != before.user_settings:
                plan = before.with_settings(own)
                if plan.continues(before):
                    row.replan(plan)
                else:
                    engine.apply_level(row)
                    engine.close_take(row)
                    engine.report_end(row, "")
                    row.restart(plan)
            row.state["plan"]["beta"] = row.plan.strength(level)
            row.is_level_new = True

    def carry_on(self, counts: Mapping[str, int]) -> None:
        """Number takes and count frames on from those of the body; see `Segmenter.counts`."""
        for row in self.rows:
            carry_on(row, counts)

    def release(self) -> None:
        """Give the rows back."""
        for row in self.rows:
            row.release()

    def snapshot(self) -> tuple[bytes, ...]:
        """Return what all limbs know."""
        self.catch_up()
        for row in self.rows:
            engine.apply_level(row)
        return tuple(
            pack_snapshot(
                row.plan,
                row.name,
                self._level,
                [],
                row.memory,
                Following(repetitions=None if row.reporter is None else row.reporter.reported),
            )
            for row in self.rows
        )

    def restore(self, blobs: tuple[bytes, ...]) -> None:
        """Go on where the limbs of a snapshot were, one for each limb.

        Raises:
            SnapshotError: If they are damaged or not those of these limbs.
        """
        if len(blobs) != len(self.rows):
            raise SnapshotError("the snapshot's limbs are not those of its settings")
        found = []
        for row, blob in zip(self.rows, blobs, strict=True):
            plan, performer, _, _, content, _, known = unpack_snapshot(blob, channel=row.plan.channel)
            same = (plan.skeleton, performer, plan.user_settings) == (
                row.plan.skeleton,
                row.name,
                row.plan.user_settings,
            )
            if not same or known.limbs:
                raise SnapshotError("the snapshot's limbs are not those of its settings")
            fresh = restored_row(plan, row.buffers, performer, content, self._body.pending)
            if fresh.reporter is not None and fresh.clock["open"]:
                fresh.reporter.go_on(known.repetitions)
            found.append(fresh)
        self.release()
        self.rows = found


def carry_on(row: Row, counts: Mapping[str, int]) -> None:
    """Number takes and count frames of a row on from the counts of another."""
    row.clock["take"] = counts["take"]
    row.note_end()
    for name in RECORDS["Counters"].names or ():
        row.state["counters"][name] = counts.get(name, 0)
