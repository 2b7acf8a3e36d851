"""Followers: what follows a performer's frames besides the segmentation of the body. All of it is off by default.

Limbs have rows of their own; moves, moves that are followed, held poses, and steps are readers
(readers.py); the phase is reported for every frame.
"""

from collections.abc import Mapping

from mossar_stream.core import engine
from mossar_stream.core.pool import Row
from mossar_stream.core.snapshot import Following, Numbers
from mossar_stream.core.station import Desk, Station
from mossar_stream.events import BODY, Event
from mossar_stream.following.alignment import Alignment, Follow
from mossar_stream.moves.groups import groups_of
from mossar_stream.moves.recognition import Recognition
from mossar_stream.poses.holding import Holding, holding_of
from mossar_stream.readers import Reader
from mossar_stream.segmenter.limbs import Limbs, NewRow
from mossar_stream.settings import LevelName, Settings
from mossar_stream.steps.stepping import Stepping


class Followers:
    """What follows the frames of one performer besides the segmentation of the body.

    Events are added to what is pending of the performer's row, in the order in which they come about: of one frame those of
    the body, of limbs, of readers in the order of `_readers`, of the phase.

    Args:
        row: The performer's.
        level: As it is now.
        recognition: Of moves, or None.
        following: Which moves are to be followed, and what follows them, or None.
        new_row: Returns a row for a limb.

    Attributes:
        followed: Which moves are to be followed.
        alignment: What follows them, or None.
        holding: What recognises held poses, or None.
        limbs: Key frames of limbs, or None.
        stepping: Steps, or None.
        desk: The performer with all of that, for the loop.
    """

    def __init__(
        self,
        row: Row,
        level: LevelName | float,
        recognition: Recognition | None,
        following: tuple[Follow, Alignment | None],
        new_row: NewRow,
    ) -> None:
        self._row = row
        self._recognition = recognition
        self.followed, self.alignment = following
        self._new_row = new_row
        self._user_settings = row.plan.user_settings
        self._numbers = Numbers()
        self.holding = self._holding_of(recognition)
        self.stepping = _stepping_of(row)
        self.limbs = self._limbs_at(level)
        self._lay()

    def _lay(self) -> None:
        """Let the loop know of what there is now."""
        limbs = self.limbs
        rows, joints = ([], []) if limbs is None else (limbs.rows, limbs.joints)
        phase = self._user_settings.phase and self._row.reporter is not None
        self.desk = Desk([Station([self._row, *rows], joints, self._readers, phase=phase)])

    @property
    def _readers(self) -> list[Reader]:
        """What reads the frames, in the order in which it reports."""
        recognition = self._recognition if self._recognition is not None and self._recognition.names else None
        readers: tuple[Reader | None, ...] = recognition, self.alignment, self.holding, self.stepping
        return [reader for reader in readers if reader is not None]

    @property
    def station(self) -> Station:
        """The performer as the loop knows it."""
        return self.desk.stations[0]

    @property
    def recognition(self) -> Recognition | None:
        """What recognises moves, or None."""
        return self._recognition

    @recognition.setter
    def recognition(self, recognition: Recognition | None) -> None:
        holding, before = self._holding_of(recognition), self.holding
        self._numbers = numbers = self.numbers
        if recognition is not None:
            recognition.count_on_from(numbers.moves)
        if holding is not None:
            holding.count_on_from(numbers.poses)
        last: list[Event] = [] if before is None else before.left(int(self._row.clock["take"]))
        if self._recognition is not None:
            last += self._recognition.last_word(recognition)
        pending = self._row.pending
        pending += [event for event in last if event not in pending]  # they are there if this was cut short
        self._recognition, self.holding = recognition, holding
        self._lay()

    @property
    def numbers(self) -> Numbers:
        """What events are numbered on from: of what reports now, otherwise of what reported last in this take."""
        known, recognition, alignment, holding = (
            self._numbers,
            self._recognition,
            self.alignment,
            self.holding,
        )
        performances, counts = (known.performances, known.counts) if alignment is None else alignment.numbers
        return Numbers(
            moves=known.moves if recognition is None else recognition.number,
            performances=performances,
            counts=known.counts | counts,
            poses=known.poses if holding is None else holding.number,
        )

    def _holding_of(self, recognition: Recognition | None) -> Holding | None:
        """Return what recognises the poses among the moves."""
        if recognition is None:
            return None
        return holding_of(recognition.moves, self._row.plan.skeleton, self._user_settings.up, self._row.name)

    def follow_moves(self, follow: Follow, alignment: Alignment | None) -> None:
        """Let something else follow moves; what is being made is decided."""
        before = self.alignment
        if before is not None and before is not alignment:
            before.decide(int(self._row.clock["take"]), self._row.pending)
        self._numbers = numbers = self.numbers
        if alignment is not None:
            alignment.count_on_from(numbers.performances, numbers.counts)
        self.followed, self.alignment = follow, alignment
        self._lay()

    def _limbs_at(self, level: LevelName | float) -> Limbs | None:
        """Return limbs as settings call for them; None if the skeleton leaves none."""
        row = self._row
        wanted = row.plan.channel == BODY and groups_of(row.plan.skeleton, row.plan.user_settings.limbs)
        return Limbs(row, level, self._new_row) if wanted else None

    def adopt(self, level: LevelName | float) -> None:
        """Go on with the settings of the row as it is now; what that ends of limbs is pending then."""
        current, limbs = self._row.plan.user_settings, self.limbs
        if current.limbs != self._user_settings.limbs:
            if limbs is not None:
                limbs.end_take()
            self.limbs = self._limbs_at(level)
            if limbs is not None:
                limbs.release()
        if _steps_differ(current, self._user_settings):
            self.stepping = _stepping_of(self._row)
        if self.alignment is not None:
            row = self._row
            self.alignment = self.alignment.adopt(current, int(row.clock["take"]), row.pending)
        up, self._user_settings = self._user_settings.up, current
        if current.up != up:
            self.recognition = self._recognition
        self.follow(level)

    def follow(self, level: LevelName | float) -> None:
        """Let limbs go on with the settings of the row, and with its level."""
        if self.limbs is not None:
            self.limbs.follow(level)
        self._lay()

    def apply_level(self) -> None:
        """Let a level that moved act, of the body and of limbs."""
        engine.apply_level(self._row)
        if self.limbs is not None:
            self.limbs.apply_level()

    def end_take(self, reason: str) -> None:
        """End the take: of readers, of the body, of limbs; then report that it has ended."""
        row = self._row
        self.apply_level()
        for reader in self._readers:
            reader.end(int(row.clock["take"]), row.pending)
        self._numbers = Numbers(moves=self.numbers.moves)
        engine.close_take(row)
        if self.limbs is not None:
            self.limbs.end_take()
        engine.report_end(row, reason)

    def forget_ranges(self) -> None:
        """Forget the running ranges, after the takes ended."""
        self._row.forget_range()
        if self.limbs is not None:
            self.limbs.forget_ranges()

    def carry_on(self, counts: Mapping[str, int]) -> None:
        """Number takes of limbs on, too."""
        if self.limbs is not None:
            self.limbs.carry_on(counts)

    def mend(self, crowd: Desk | None) -> None:
        """Finish what an exception cut short; see `engine.mend`."""
        engine.mend(self.desk, crowd)
        self._lay()

    def release(self) -> None:
        """Give back what limbs lie in."""
        if self.limbs is not None:
            self.limbs.release()

    @property
    def bytes_taken(self) -> int:
        """Bytes of what is known here, besides what is shared with others."""
        return sum(len(reader.state) for reader in self._readers) + (
            0 if self.limbs is None else self.limbs.bytes_taken
        )

    def snapshot(self, *, with_moves: bool = True) -> Following:
        """Return everything that is known here; see `Segmenter.snapshot`."""
        recognition, reporter = self._recognition, self._row.reporter
        return Following(
            moves=None if recognition is None or not with_moves else recognition.moves_text,
            digest=b"" if recognition is None else recognition.digest,
            recognition=None if recognition is None else recognition.to_bytes(),
            repetitions=None if reporter is None else reporter.reported,
            limbs=() if self.limbs is None else self.limbs.snapshot(),
            steps=None if self.stepping is None else self.stepping.to_bytes(),
            follow=self.followed,
            followed=None if self.alignment is None else self.alignment.to_bytes(),
            poses=None if self.holding is None else self.holding.to_bytes(),
            numbers=self.numbers,
        )

    def restore(self, known: Following) -> None:
        """Go on where a snapshot was made; the row and the recognition are there already.

        Raises:
            SnapshotError: If it is damaged, or of other settings.
        """
        row = self._row
        if row.reporter is not None and row.clock["open"]:
            row.reporter.go_on(known.repetitions)
        if self.limbs is not None:
            self.limbs.restore(known.limbs)
        if self.stepping is not None:
            self.stepping.go_on_from(known.steps)
        if self.holding is not None and known.poses is not None:
            same = self._recognition is not None and self._recognition.digest == known.digest
            if same:
                self.holding.go_on_from(known.poses)
            else:
                self.holding.count_on_from(known.numbers.poses)
        self._numbers = known.numbers
        self._lay()


def _stepping_of(row: Row) -> Stepping | None:
    current = row.plan.user_settings
    return (
        Stepping(row.plan.skeleton, current, row.name) if current.steps and row.plan.channel == BODY else None
    )


def _steps_differ(current: Settings, before: Settings) -> bool:
    fields = ("steps", "feet", "step_sensitivity", "up")
    return any(getattr(current, name) != getattr(before, name) for name in fields)
