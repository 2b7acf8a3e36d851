"""Stepping: a performer's frames in, step events out."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import (
    LEAST_WAY,
    LEAST_WAY_OF_ANKLES,
    NO_NEWS,
    RECORDS,
    STRIKE,
    address_of_follow_feet,
)
from mossar_stream.errors import SnapshotError
from mossar_stream.events import Event, StepEvent
from mossar_stream.settings import Settings
from mossar_stream.settings.feet import SIDES
from mossar_stream.skeleton import Skeleton
from mossar_stream.steps.feet import feet_of, tops_of

STEPS = RECORDS["Steps"]
UPWARD_AXES = {
    "x": (1, 0, 0),
    "y": (0, 1, 0),
    "z": (0, 0, 1),
    "-x": (-1, 0, 0),
    "-y": (0, -1, 0),
    "-z": (0, 0, -1),
}


class Stepping:
    """Follows the feet of one performer; all its state is one record of fixed size.

    Args:
        skeleton: The performer's joints.
        settings: `feet`, `step_sensitivity` and `up` are used.
        performer: Name that events carry.

    Raises:
        FrameError: If the skeleton has no feet that are known.
    """

    def __init__(self, skeleton: Skeleton, settings: Settings, performer: str) -> None:
        self._performer = performer
        self.state, self.store = np.zeros(STEPS.itemsize, np.uint8), np.zeros(0, np.uint8)
        self._state = self.state.view(STEPS)
        state = self._state[0]
        feet = feet_of(skeleton, settings.feet)
        for side, joints in enumerate(feet[name] for name in SIDES):
            state["feet"][side]["points"] = [*joints, -1, -1, -1, -1][:4]
            state["feet"][side]["rest"] = np.nan
        tops = [joint for joint in tops_of(skeleton) if all(joint not in own for own in feet.values())]
        state["tops"] = [*tops, -1, -1, -1, -1][:4]
        state["sensitivity"] = settings.step_sensitivity
        rich = min(len(joints) for joints in feet.values()) > 1
        state["way"] = (LEAST_WAY if rich else LEAST_WAY_OF_ANKLES) / settings.step_sensitivity
        if settings.up != "auto":
            state["up"], state["is_up_given"] = UPWARD_AXES[settings.up], 1
        state["time"] = state["sample"] = state["looked"] = -np.inf
        state["feet"]["last"] = -np.inf
        state["due"] = -np.inf
        self.reported = (-1, 0)  # take, and number of its latest event
        self.address = address_of_follow_feet()

    def report(
        self, take: int, origin: NDArray[np.float64] | None = None
    ) -> tuple[list[Event], tuple[int, int]]:
        """Return the events of the last frame, the earlier one first.

        Args:
            take: Number of the take that is open.
            origin: Where the positions are counted from, m.
        """
        number = self.reported[1] if self.reported[0] == take else 0
        found = sorted(
            (float(foot["time"]), side)
            for side, foot in enumerate(self._state[0]["feet"])
            if foot["event"] != NO_NEWS
        )
        events = [
            self._event((take, number + k), side, time, origin) for k, (time, side) in enumerate(found, 1)
        ]
        return list(events), (take, number + len(found))

    def _event(
        self, which: tuple[int, int], side: int, time: float, origin: NDArray[np.float64] | None
    ) -> StepEvent:
        """Return the event of a foot, and of which take and number it is."""
        state, (take, number) = self._state[0], which
        foot = state["feet"][side]
        place = foot["place"] if origin is None else foot["place"] + origin
        return StepEvent(
            performer=self._performer,
            id=f"{self._performer}/step/{take}/{number}",
            rev=1,
            status="strike" if foot["event"] == STRIKE else "off",
            take=take,
            side=SIDES[side],
            time=time,
            position=(round(float(place[0]), 6), round(float(place[1]), 6), round(float(place[2]), 6)),
            confidence=round(float(foot["confidence"]), 4),
            decided_time=float(state["time"]),
        )

    def end(self, _take: int, _pending: list[Event]) -> None:
        """Begin anew after the end of a take."""
        state = self._state[0]
        for foot in state["feet"]:
            foot["state"], foot["first"], foot["rest"] = 0, foot["count"], np.nan
            foot["judged"], foot["last"] = foot["count"], -np.inf
        state["belt"], state["drift"] = 0.0, 0.0
        state["time"] = state["sample"] = state["looked"] = state["due"] = -np.inf

    def to_bytes(self) -> bytes:
        """Return the state, for a snapshot."""
        self._state["take"], self._state["number"] = self.reported
        return self._state.tobytes()

    def go_on_from(self, known: bytes | None) -> None:
        """Go on with the state of a snapshot.

        Raises:
            SnapshotError: If it is of other feet, or contradicts itself.
        """
        if known is None or len(known) != self._state.nbytes:
            raise SnapshotError("the snapshot's state of steps is missing or of another size")
        fresh = np.frombuffer(known, STEPS).copy()
        for fixed in ("tops", "sensitivity", "way", "is_up_given"):
            if not np.array_equal(fresh[fixed], self._state[fixed]):
                raise SnapshotError("the snapshot's state of steps is of other settings")
        feet, counts = fresh["feet"], fresh["feet"]["count"]
        if not np.array_equal(feet["points"], self._state["feet"]["points"]):
            raise SnapshotError("the snapshot's state of steps is of other feet")
        within = (
            (feet["first"] >= 0)
            & (feet["first"] <= counts)
            & (counts < 1 << 60)
            & (feet["peak_at"] <= counts)
            & (feet["judged"] >= feet["first"])
            & (feet["judged"] <= counts)
        )
        belt = np.isfinite(fresh["belt"]).all() and np.isfinite(fresh["drift"]).all()
        states = (feet["state"] >= 0) & (feet["state"] <= 3) & (feet["event"] >= 0) & (feet["event"] <= 2)
        if (
            not (within & states & (feet["peak_at"] >= 0)).all()
            or not belt
            or (fresh["number"] < 0).any()
            or np.isnan(fresh["due"]).any()
        ):
            raise SnapshotError("the snapshot's state of steps contradicts itself")
        self._state[:] = fresh
        self.reported = int(fresh["take"][0]), int(fresh["number"][0])
