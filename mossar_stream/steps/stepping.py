"""Stepping: a performer's frames in, step events out."""

import math

import numpy as np
from numpy.typing import NDArray

from mossar_stream.errors import SnapshotError
from mossar_stream.events import Event, StepEvent
from mossar_stream.settings import Settings
from mossar_stream.settings.feet import SIDES
from mossar_stream.skeleton import Skeleton
from mossar_stream.steps.feet import feet_of, tops_of
from mossar_stream.steps.tracking import (
    LEAST_WAY,
    LEAST_WAY_OF_ANKLES,
    NONE,
    STEPS,
    STRIKE,
    follow_feet,
    follow_frame,
)

AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "-x": (-1, 0, 0), "-y": (0, -1, 0), "-z": (0, 0, -1)}


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
        self._memory = np.zeros(STEPS.itemsize, np.uint8)
        self._state = self._memory.view(STEPS)
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
            state["up"], state["is_up_given"] = AXES[settings.up], 1
        state["time"] = state["sample"] = -np.inf
        state["take"] = -1
        self._has_news = False
        self._latest = -math.inf  # s, of the frame that `hold` took in
        # No frame: the kernels are compiled now, and never while frames come in.
        nothing = np.zeros((1, len(skeleton), 3), np.float32)
        follow_feet(self._memory, nothing, np.zeros(1), 0, 0)
        follow_frame(self._memory, nothing, math.nan)

    def hold(self, position: NDArray[np.float32], time: float) -> bool:
        """Take one frame in, and tell whether it brings no news; if it does, `follow` says so when called with the frame.

        Args:
            position: (1, J, 3) m.
            time: s.
        """
        self._has_news = follow_frame(self._memory, position, time)
        self._latest = time
        return not self._has_news

    def follow(self, positions: NDArray[np.float32], times: NDArray[np.float64], begin: int) -> int:
        """Take frames in until there is news; return the number of the frame that brought it, n if none did."""
        if self._has_news and len(times) == 1 and times[0] == self._latest:  # as `hold` has found
            self._has_news = False
            return 0
        self._has_news = False
        stop: int = follow_feet(self._memory, positions, times, begin, len(times))
        return stop

    def news(self, take: int, pending: list[Event], origin: NDArray[np.float64] | None = None) -> None:
        """Tell of the frame that `follow` stopped at, the earlier event first.

        Args:
            take: Number of the take that is open.
            pending: Gets the events.
            origin: Where the positions are counted from, m.
        """
        state = self._state[0]
        if take != state["take"]:
            state["take"], state["number"] = take, 0
        found = sorted(
            (float(foot["time"]), side) for side, foot in enumerate(state["feet"]) if foot["event"] != NONE
        )
        pending += [self._event(take, side, time, origin) for time, side in found]

    def _event(self, take: int, side: int, time: float, origin: NDArray[np.float64] | None) -> StepEvent:
        state = self._state[0]
        foot = state["feet"][side]
        state["number"] += 1
        place = foot["place"] if origin is None else foot["place"] + origin
        return StepEvent(
            performer=self._performer,
            id=f"{self._performer}/step/{take}/{int(state['number'])}",
            rev=1,
            status="strike" if foot["event"] == STRIKE else "off",
            take=take,
            side=SIDES[side],
            time=time,
            position=(round(float(place[0]), 6), round(float(place[1]), 6), round(float(place[2]), 6)),
            confidence=round(float(foot["confidence"]), 4),
            decided_time=float(state["time"]),
        )

    def forget(self) -> None:
        """Begin anew after the end of a take."""
        state = self._state[0]
        for foot in state["feet"]:
            foot["state"], foot["first"], foot["rest"] = 0, foot["count"], np.nan
        state["time"] = state["sample"] = -np.inf

    @property
    def bytes_taken(self) -> int:
        """Bytes of the state."""
        return self._state.nbytes

    def to_bytes(self) -> bytes:
        """Return the state, for a snapshot."""
        return self._state.tobytes()

    def go_back_to(self, known: bytes) -> None:
        """Forget the frames since `to_bytes` returned this."""
        self._has_news = False
        self._state[:] = np.frombuffer(known, STEPS)

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
        )
        states = (feet["state"] >= 0) & (feet["state"] <= 3) & (feet["event"] >= 0) & (feet["event"] <= 2)
        if not (within & states & (feet["peak_at"] >= 0)).all() or (fresh["number"] < 0).any():
            raise SnapshotError("the snapshot's state of steps contradicts itself")
        self._state[:] = fresh
