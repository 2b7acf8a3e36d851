"""Body: the state of the person in a slot, and whether a pose continues the one before."""

from bisect import bisect_left
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.people.samples import Samples
from mossar_adapters.receiving.batch import FARTHEST
from mossar_stream import Skeleton

# A step from frame to frame beyond JUMP + QUICK * dt (root mean square over the joints) is looked into: the labelled
# recordings stay below it in all but 0.02 % of the frames, and two people are farther apart.
JUMP: Final = 0.1  # m
QUICK: Final = 3.0  # m/s
PAUSE: Final = 0.25  # s without frames after which a person may be somewhere else
_LATE: Final = 2.5  # times as long as usual between two frames: another person may have the id now
_SMOOTH: Final = 0.1  # share of each new time between frames
_MARK: Final = 0.15  # s between two poses that a velocity is taken of
_FASTEST: Final = 2.5  # m/s of a whole body; more is noise


class Body:
    """The person in a slot.

    Args:
        name: Of the slot.
        number: Of the slot, from 0.
    """

    __slots__ = (
        "_limit",
        "_mark",
        "_mark_due",
        "_mark_time",
        "_older",
        "_older_time",
        "_usual",
        "id",
        "met",
        "name",
        "number",
        "pinned",
        "pose",
        "samples",
        "skeleton",
        "time",
    )

    def __init__(self, name: str, number: int) -> None:
        self.name = name
        self.number = number
        self.id: str | None = None  # the sender's, at present or last
        self.met: int = 0  # number of people met before this one; 0 while the slot was never used
        self.pinned = False  # whether the slot is kept for this person, however long it is away
        self.time = -np.inf  # s, when last seen
        self.pose: NDArray[Any] = np.zeros((0, 3))  # (J, 3) metres, each joint where it was seen last
        self.skeleton: Skeleton | None = None
        self.samples = Samples(0)
        self._limit = 0  # joints
        self._mark = self._older = self.pose  # poses at two earlier times
        self._mark_time = self._older_time = self._mark_due = -np.inf  # s
        self._usual = PAUSE  # s between frames, smoothed

    @property
    def used(self) -> bool:
        """Whether the slot was ever used."""
        return self.met > 0

    def begin(self, pose: NDArray[Any], time: float, skeleton: Skeleton | None) -> None:
        """Start with another person, or with another skeleton."""
        self.skeleton = skeleton
        self.samples = Samples(len(pose))
        self.settle(pose, time)

    def settle(self, pose: NDArray[Any], time: float) -> None:
        """Go on with the same person somewhere else, or later."""
        self.pose = pose.copy() if len(pose) != len(self.pose) else filled(pose, self.pose)
        self.time = self._mark_time = self._older_time = time
        self._mark = self._older = self.pose
        self._mark_due = time + _MARK
        self._limit = len(pose)
        if time >= self.samples.due:
            self.samples.add(pose, time)

    def shift(self, seconds: float) -> None:
        """Go on with another clock."""
        self.time += seconds
        self._mark_time += seconds
        self._older_time += seconds
        self._mark_due += seconds
        self.samples.shift(seconds)

    def run(self, positions: NDArray[Any], times: NDArray[np.float64]) -> int:
        """Follow frames as long as they go on from one to the next.

        Args:
            positions: (n, J, 3), metres.
            times: (n,), s, in order.

        Returns:
            How many of them do.
        """
        count = len(times)
        if count == 1 or positions.shape[1] != self._limit:
            return int(self.follow(positions[0], float(times[0])))
        steps = np.empty_like(positions)
        np.subtract(positions[1:], positions[:-1], out=steps[1:])
        np.subtract(positions[0], self.pose, out=steps[0])
        flat = steps.reshape(count, -1)
        moments = times.tolist()  # on ten numbers Python is several times as fast as NumPy
        if self._goes_on(np.einsum("nk,nk->n", flat, flat).tolist(), moments):
            self._keep(positions, moments)
            return count
        for i in range(count):
            if not self.follow(positions[i], float(times[i])):
                return i
        return count

    def follow(self, pose: NDArray[Any], time: float) -> bool:
        """Follow one frame, (J, 3), if it goes on from the one before; return whether it does."""
        pause = time - self.time
        if not 0 <= pause <= PAUSE or pause > _LATE * self._usual or len(pose) != self._limit:
            return False
        step = (pose - self.pose).ravel()
        limit = JUMP + QUICK * pause
        if np.dot(step, step) <= limit * limit * self._limit:
            self.pose = pose.copy()
        else:
            seen = ~np.isnan(step)
            if not seen.any():
                return True  # no joint is in the frame: the person may be anywhere soon
            known = step[seen]
            if np.dot(known, known) > limit * limit * (len(known) / 3):
                return False
            self.pose = filled(pose, self.pose)
        self.time = time
        self._usual += (pause - self._usual) * _SMOOTH
        if time >= self._mark_due:
            self._put_mark(self.pose, time)
        if time >= self.samples.due:
            self.samples.add(pose, time)
        return True

    def _goes_on(self, squares: list[float], times: list[float]) -> bool:
        """Return whether all frames go on, by the squares of the steps (m^2, over all joints) and the times (s)."""
        most = min(PAUSE, _LATE * self._usual)
        before = self.time
        for square, time in zip(squares, times, strict=True):
            pause = time - before
            limit = JUMP + QUICK * pause
            # Also where a joint is missing.
            if not (0 <= pause <= most and square <= limit * limit * self._limit):
                return False
            before = time
        return True

    def _keep(self, positions: NDArray[Any], times: list[float]) -> None:
        """Note two or more frames that go on."""
        last = times[-1]
        while last >= self._mark_due:
            i = bisect_left(times, self._mark_due)
            self._put_mark(positions[i].copy(), times[i])
        while last >= self.samples.due:
            i = bisect_left(times, self.samples.due)
            self.samples.add(positions[i], times[i])
        self._usual += (last - times[-2] - self._usual) * _SMOOTH
        self.pose, self.time = positions[-1].copy(), last

    def _put_mark(self, pose: NDArray[Any], time: float) -> None:
        self._older, self._older_time = self._mark, self._mark_time
        self._mark, self._mark_time, self._mark_due = pose, time, time + _MARK

    def velocity(self) -> NDArray[np.float64]:
        """Return the last known velocity of the whole body, (3,) m/s."""
        span = self.time - self._older_time
        if span <= 0:
            return np.zeros(3)
        velocity = (centre(self.pose) - centre(self._older)) / span
        speed = float(np.sqrt(velocity @ velocity))
        return velocity * min(1.0, _FASTEST / max(speed, 1e-9))


def filled(pose: NDArray[Any], before: NDArray[Any]) -> NDArray[Any]:
    """Return a pose with each joint that is missing, or too far off to be true, where it was before."""
    return np.where(np.abs(pose) <= FARTHEST, pose, before)


def centre(pose: NDArray[Any]) -> NDArray[np.float64]:
    """Return the middle of the joints that are there, (3,) metres."""
    gone = np.isnan(pose[:, 0])
    here = pose[~gone] if gone.any() else pose
    found: NDArray[np.float64] = (here.sum(axis=0) / max(len(here), 1)).astype(np.float64)
    return found
