"""Stepping: a performer's frames in, step events out."""

import numpy as np

from mossar_stream.core.kernels import LEAST_WAY, LEAST_WAY_OF_ANKLES, RECORDS, StepReader
from mossar_stream.errors import SnapshotError
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


class Stepping(StepReader):
    """Follows the feet of one performer; all its state is one record of fixed size.

    Args:
        skeleton: The performer's joints.
        settings: `feet`, `step_sensitivity` and `up` are used.
        performer: Name that events carry.

    Raises:
        FrameError: If the skeleton has no feet that are known.
    """

    def __init__(self, skeleton: Skeleton, settings: Settings, performer: str) -> None:
        self.performer = performer
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

    def number(self, take: int) -> int:
        """Return the number of the latest step in a take."""
        return int(self._state["number"][0]) if self._state["take"][0] == take else 0

    def count_on_from(self, take: int, number: int) -> None:
        """Number the steps of a take on from the number of the latest one."""
        self._state["take"], self._state["number"] = take, number

    def to_bytes(self) -> bytes:
        """Return the state, for a snapshot."""
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
