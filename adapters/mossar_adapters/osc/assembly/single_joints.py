"""Frames from messages that carry one joint each.

Nothing marks the end of a frame in these protocols. A frame is closed, whichever is first:

- when all joints of the performer are there, so that no time is lost;
- when a joint comes again;
- when the joint that usually opens a frame comes while most others are there (one was lost on the way);
- when a joint comes after the longest wait for the second time in a row (the stream was met in mid-frame);
- when nothing comes after the joint that ended the frame before, or nothing at all for a tenth of a second.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.units import Scale, height
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.osc.assembly.known_joints import ClosedFrame, KnownJoints, Row
from mossar_adapters.osc.profiles.profile import Intake, Message
from mossar_stream.frames import performer_name
from mossar_stream.skeleton import MAX_NAME, Skeleton

MAX_PEOPLE = 64  # per profile; the one unheard for longest makes room
_GAP_LOW, _GAP_HIGH, _INTERVAL = 0.004, 0.1, 0.04  # s

Parents = Callable[[Sequence[str]], tuple[tuple[int, ...], int]]
Scaling = Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], Scale]]


class People:
    """The performers of one profile.

    Args:
        intake: Where frames go.
        scaling: Takes (n, J, 3) raw positions of the first frames and returns factor (3,) and the scale.
        parents: Finds parents and root of named joints.
    """

    def __init__(self, intake: Intake, scaling: Scaling, parents: Parents = with_known_parents) -> None:
        self._intake = intake
        self._scaling = scaling
        self._parents = parents
        self._people: dict[str, _Person] = {}

    def put(self, message: Message, person: str, joint: str, xyzc: Row) -> None:
        """Take one joint.

        Args:
            message: The message it came in.
            person: Id of the performer, empty if the protocol has none.
            joint: Name.
            xyzc: Position and confidence (NaN where the protocol has none).
        """
        name = self._intake.senders.name(message.sender, person)
        found = self._people.get(name)
        if found is None:
            if len(self._people) == MAX_PEOPLE:
                del self._people[min(self._people, key=lambda key: self._people[key].last)]
            found = self._people[name] = _Person(name, self._intake, self._scaling, self._parents)
        found.put(_clean(joint), xyzc, message.arrival)

    def lost(self, message: Message, person: str, reason: str) -> None:
        """Close what a performer has and pass on that it left."""
        name = self._intake.senders.name(message.sender, person)
        found = self._people.pop(name, None)
        if found is not None:
            found.finish()
        self._intake.batch.leave(name, reason)

    def idle(self, now: float) -> None:
        """Close the frames that nothing more comes for."""
        for person in self._people.values():
            person.idle(now)

    def pending(self) -> bool:
        """Return whether a frame is open or held back."""
        return any(person.pending for person in self._people.values())


class _Person:
    """The frames of one performer."""

    def __init__(self, name: str, intake: Intake, scaling: Scaling, parents: Parents) -> None:
        self._name, self._intake, self._scaling, self._parents = name, intake, scaling, parents
        self._known = KnownJoints()
        self._skeleton: Skeleton | None = None
        self._factor: NDArray[np.float64] | None = None  # (3,) metres per unit
        self._unit = "m"
        self._rows: dict[str, Row] = {}
        self._opener: str | None = None  # joint that usually opens a frame
        self._waited: tuple[float, str] = (0.0, "")  # longest wait in the open frame (s), and for which joint
        self._waited_before = ""  # that joint in the frame before
        self._newest = self._tail = ""  # latest joint of the open frame, last joint of the frame before
        self._opened = 0.0  # arrival of the open frame's first joint, s
        self._interval = _INTERVAL  # s between the openings of frames, smoothed
        self.last = 0.0  # arrival of the latest joint, s

    @property
    def pending(self) -> bool:
        return bool(self._rows) or self._known.holding

    @property
    def _pause(self) -> float:
        """The wait that is rather between frames than between joints, s."""
        return min(max(self._interval / 2, _GAP_LOW), _GAP_HIGH)

    def put(self, joint: str, xyzc: Row, arrival: float) -> None:
        wait = arrival - self.last
        if self._rows and self._begins(joint, wait):
            self._close()
        self._known.note(joint)
        if not self._rows:
            self._open(joint, wait, arrival)
        self._waited = max(self._waited, (wait, joint))
        self._rows[joint] = xyzc
        self.last, self._newest = arrival, joint
        if self._known.learnt and len(self._rows) == len(self._known.names):
            self._close()

    def idle(self, now: float) -> None:
        gap = self._pause if self._newest == self._tail else _GAP_HIGH
        if self._rows and now - self.last > gap:
            self._close()
        if self._known.overdue(now):
            self._emit(self._known.release())

    def finish(self) -> None:
        if self._rows:
            self._close()
        self._emit(self._known.release())

    def _begins(self, joint: str, wait: float) -> bool:
        """Return whether a joint begins a new frame."""
        if joint in self._rows:
            return True
        if joint == self._opener and 2 * len(self._rows) > len(self._known.names):
            return True
        return joint == self._waited_before and wait > max(0.75 * self._interval, _GAP_LOW)

    def _open(self, joint: str, wait: float, arrival: float) -> None:
        if self._opener is None or wait > self._pause:
            self._opener = joint
        if 0 < arrival - self._opened < 1.0:
            self._interval += (arrival - self._opened - self._interval) / 4
        self._opened = arrival

    def _close(self) -> None:
        rows, self._rows = self._rows, {}
        self._waited_before, self._waited = self._waited[1], (0.0, "")
        self._tail = self._newest
        self._emit(self._known.admit(ClosedFrame(rows, self._opened)))

    def _emit(self, frames: Sequence[ClosedFrame]) -> None:
        if not frames:
            return
        tables = np.stack([self._known.table(frame.rows, 4) for frame in frames])  # (n, J, 4)
        if self._factor is None:
            self._factor, scale = self._scaling(tables[:, :, :3])
            self._unit = scale.note or "m"
        if self._skeleton is None or len(self._skeleton) != tables.shape[1]:
            names = tuple(self._known.names)
            self._skeleton = Skeleton(names, *self._parents(names))
        for frame, table in zip(frames, tables, strict=True):
            confidence = None if np.isnan(table[:, 3]).all() else table[:, 3]
            self._intake.frame(
                self._name,
                self._skeleton,
                table[:, :3] * self._factor,
                frame.arrival,
                confidence=confidence,
                unit=self._unit,
            )


def isotropic(choose: Callable[[float], Scale]) -> Scaling:
    """Return a scaling that multiplies all axes alike.

    Args:
        choose: Makes the scale of the height of the skeleton.
    """

    def scaling(positions: NDArray[np.float64]) -> tuple[NDArray[np.float64], Scale]:
        scale = choose(height(positions))
        return np.full(3, scale.metres), scale

    return scaling


def _clean(joint: str) -> str:
    if 0 < len(joint) <= MAX_NAME and joint.isprintable():
        return joint
    return performer_name(joint)
