"""Gait: steps as a table, and the measures of a walk: cadence, step time, stance and swing, symmetry."""

from collections.abc import Sequence

import msgspec
import numpy as np

from mossar_stream.events import Side, StepEvent

LONGEST_STEP = 3.0  # s between two strikes; a longer time is a pause, not a step
SIDES: tuple[Side, Side] = ("left", "right")


class Step(msgspec.Struct, frozen=True):
    """One step, from the strike of a foot to its next strike.

    Args:
        side: Of the foot.
        start: Time of its strike, s.
        end: Time of its next strike, s; None of the last step, or where a pause follows.
        step_time: s since the other foot came down; None of the first step, or after a pause.
        stance: s until the foot left the ground.
        swing: s from then until it came down again.
        cadence: Steps a minute: 60 / `step_time`.
        step_length: m from the other foot's last strike to this one.
    """

    side: Side
    start: float
    end: float | None = None
    step_time: float | None = None
    stance: float | None = None
    swing: float | None = None
    cadence: float | None = None
    step_length: float | None = None


class Gait(msgspec.Struct, frozen=True):
    """Medians of the steps of a recording; None where there are too few.

    Args:
        steps: Number of strikes.
        cadence: Steps a minute, by the median step time.
        step_time: Median of each side, s.
        stance: Median of each side, s.
        swing: Median of each side, s.
        stance_share: Median share of the cycle in which the foot stands, of each side.
        asymmetry: Percent: abs(left - right) / mean of both, of step time, stance and swing.
    """

    steps: int
    cadence: float | None
    step_time: dict[Side, float | None]
    stance: dict[Side, float | None]
    swing: dict[Side, float | None]
    stance_share: dict[Side, float | None]
    asymmetry: dict[str, float | None]


def step_table(events: Sequence[StepEvent]) -> list[Step]:
    """Return the steps of step events, in the order of time."""
    strikes = sorted((event for event in events if event.status == "strike"), key=lambda event: event.time)
    found = []
    for number, strike in enumerate(strikes):
        end = next((e.time for e in strikes[number + 1 :] if e.side == strike.side), None)
        end = None if end is None or end - strike.time > LONGEST_STEP else end
        offs = [e.time for e in events if (e.status, e.side) == ("off", strike.side) and e.time > strike.time]
        off = min((time for time in offs if end is None or time < end), default=None)
        off = None if off is None or off - strike.time > LONGEST_STEP else off
        before = strikes[number - 1] if number else None
        is_next = (
            before is not None and before.side != strike.side and strike.time - before.time <= LONGEST_STEP
        )
        step_time = length = None
        if before is not None and is_next:
            step_time = strike.time - before.time
            length = float(np.linalg.norm(np.subtract(strike.position, before.position)))
        found.append(
            Step(
                strike.side,
                strike.time,
                end,
                step_time,
                None if off is None else off - strike.time,
                None if off is None or end is None else end - off,
                60.0 / step_time if step_time else None,
                length,
            )
        )
    return found


def gait_of(events: Sequence[StepEvent]) -> Gait:
    """Return the medians of the steps of a recording."""
    steps = step_table(events)
    sides = {side: [step for step in steps if step.side == side] for side in SIDES}
    medians: dict[str, dict[Side, float | None]] = {
        name: {side: _median([getattr(step, name) for step in own]) for side, own in sides.items()}
        for name in ("step_time", "stance", "swing")
    }
    shares: dict[Side, float | None] = {
        side: _median([s.stance / (s.end - s.start) if s.stance and s.end else None for s in own])
        for side, own in sides.items()
    }
    step_time = _median([step.step_time for step in steps])
    return Gait(
        len(steps),
        60.0 / step_time if step_time else None,
        medians["step_time"],
        medians["stance"],
        medians["swing"],
        shares,
        {name: asymmetry(own["left"], own["right"]) for name, own in medians.items()},
    )


def asymmetry(left: float | None, right: float | None) -> float | None:
    """Return |left - right| / mean of both, percent; None where one is missing or both are 0."""
    if left is None or right is None or not abs(left) + abs(right):
        return None
    return 100.0 * abs(left - right) / (0.5 * (abs(left) + abs(right)))


def _median(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None
