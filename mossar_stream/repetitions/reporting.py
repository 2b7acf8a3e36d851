"""Reporting: the events of counted repetitions, and their revisions when a later analysis changes them."""

import math
from collections.abc import Iterable
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import ANALYSIS_INTERVAL, CYCLES, LONGEST_SILENCE, STAMP_ROUNDING
from mossar_stream.errors import SnapshotError
from mossar_stream.events import BODY, Event, PhaseEvent, RepetitionEvent, RepetitionStatus
from mossar_stream.skeleton import Skeleton

TALLY = ["clear", "dropped", "cycles", "changed", "latest", "origin"]  # all at once are read quicker
NO_CYCLE: dict[str, Any] = {"count": 0} | dict.fromkeys(
    ("period", "tempo", "start", "end", "amplitude", "joint")
)


class Reported(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What was reported so far.

    Args:
        total: Repetitions of the take.
        revisions: Messages by number of the repetition, for those that may still change.
        phase: Time of the last reported phase, s, and whether it had one.
    """

    total: int = 0
    revisions: dict[int, int] = {}
    phase: tuple[float, bool] = (-math.inf, False)


def latest_repetitions(events: Iterable[Event]) -> list[RepetitionEvent]:
    """Return the repetitions that events report, each as it was reported at last, without those that were withdrawn.

    Their `total` is that of the repetition: how many there were with it.
    """
    latest = {event.id: event for event in events if isinstance(event, RepetitionEvent)}
    return [
        msgspec.structs.replace(event, total=number_of(event))
        for event in latest.values()
        if event.status == "counted"
    ]


def number_of(event: RepetitionEvent) -> int:
    """Return the number of a repetition in its take, from 1."""
    return int(event.id.rpartition("/r")[2])


class RepetitionReporter:
    """The events of the repetitions of one performer, or of a limb.

    Args:
        skeleton: The joints.
        performer: Name that events carry.
        channel: The same.

    Attributes:
        reported: What was reported so far; methods return what it is once their events are pending, and change nothing.
    """

    def __init__(self, skeleton: Skeleton, performer: str, channel: str = BODY) -> None:
        self._performer = performer
        self._channel = channel
        self._names = skeleton.names
        self.reported = Reported()

    def use(self, headers: NDArray[np.void]) -> None:
        """Report what is counted in a (1,) `Counting` from now on."""
        self._tally = headers[TALLY]  # views
        self._cycles = headers["cycle"][0]

    @property
    def total(self) -> int:
        """Repetitions counted in this take."""
        clear, dropped, cycles, *_ = self._tally.tolist()[0]
        return dropped + cycles if clear else 0

    def report(self, take: int) -> tuple[list[Event], Reported]:
        """Return the events of an analysis that changed something: repetitions withdrawn, then those new or changed."""
        clear, dropped, cycles, changed, *_ = self._tally.tolist()[0]
        total = dropped + cycles if clear else 0
        standing, revisions = min(self.reported.total, total), dict(self.reported.revisions)
        events = [
            self._event((take, number, number - 1), "withdrawn", revisions)
            for number in range(self.reported.total, total, -1)
        ]
        events += [
            self._event((take, number, max(number, standing)), "counted", revisions)
            for number in range(dropped + changed + 1, total + 1)
        ]
        still = {number: rev for number, rev in revisions.items() if number > dropped}
        return events, Reported(total, still, self.reported.phase)

    def phase(self, time: float) -> float | None:
        """Return where in the cycle a frame is, s: 0 to 1 from where cycles begin; None out of a bout."""
        clear, _, cycles, *_, origin = self._tally.tolist()[0]
        last = cycles - 1
        if last < 0 or not clear:
            return None
        end, period = self._cycles[["ends", "period"]].tolist()[last]
        since = time - origin - end
        most = LONGEST_SILENCE * period + ANALYSIS_INTERVAL + STAMP_ROUNDING
        return (since / period) % 1.0 if since <= most else None

    def report_phase(self, take: int, time: float) -> tuple[list[Event], Reported]:
        """Return the phase of a frame, s, unless it was reported, or nothing repeats and that was reported."""
        phase, before = self.phase(time), self.reported.phase
        reported = Reported(self.reported.total, self.reported.revisions, (time, phase is not None))
        if time == before[0] or (phase is None and not before[1]):
            return [], reported
        event = PhaseEvent(
            performer=self._performer, take=take, channel=self._channel, time=time, phase=phase
        )
        return [event], reported

    def _event(
        self, which: tuple[int, int, int], status: RepetitionStatus, revisions: dict[int, int]
    ) -> Event:
        """Return the event of a repetition: its take, its number, the total; its revision is counted on."""
        take, number, total = which
        revision = revisions[number] = revisions.get(number, 0) + 1
        channel = "" if self._channel == BODY else f"{self._channel}/"
        withdrawn = status == "withdrawn"
        _, dropped, _, _, latest, _ = self._tally.tolist()[0]
        return RepetitionEvent(
            performer=self._performer,
            id=f"{self._performer}/{channel}{take}/r{number}",
            rev=revision,
            status=status,
            take=take,
            channel=self._channel,
            total=total,
            decided_time=latest,
            **(NO_CYCLE if withdrawn else self._facts(number - dropped - 1)),
        )

    def _facts(self, place: int) -> dict[str, Any]:
        """Return what an event says of a cycle."""
        cycle, origin = self._cycles[place], self._tally["origin"].item()
        period = None if np.isnan(cycle["period"]) else float(cycle["period"])
        return {
            "count": int(cycle["count"]),
            "period": period,
            "tempo": None if period is None else 60.0 / period,
            "start": origin + float(cycle["begins"]),
            "end": origin + float(cycle["ends"]),
            "amplitude": float(cycle["amplitude"]),
            "joint": self._names[cycle["joint"]],
        }

    def go_on(self, reported: Reported | None) -> None:
        """Go on where a snapshot was made; what is counted is there already.

        Raises:
            SnapshotError: If it does not fit what is counted.
        """
        total = self.total
        fits = reported is not None and 0 <= reported.total <= total and len(reported.revisions) <= 2 * CYCLES
        if reported is None or not fits:
            raise SnapshotError("the snapshot's repetitions contradict themselves")
        self.reported = reported
