"""Frames from messages that carry one joint each.

Few senders mark the end of a frame in these protocols. A frame is closed, whichever is first:

- when the sender marks its end (`end_frames`); then only a joint that comes again, and a second without any, close it, too;
- when all joints of the performer are there, so that no time is lost;
- when a joint comes again;
- when the joint that usually opens a frame comes while most others are there (one was lost on the way);
- when a joint comes after the longest wait for the second time in a row (the stream was met in mid-frame);
- when nothing comes after the joint that ended the frame before, or nothing at all for a tenth of a second.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.units import Scale, height
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.newest import Newest
from mossar_adapters.osc.assembly.known_joints import ClosedFrame, KnownJoints, Row
from mossar_adapters.osc.profiles.profile import Context, Message
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.receiving.recent import Recent
from mossar_adapters.receiving.senders import MAX_SENDERS
from mossar_adapters.source import Departure
from mossar_stream import MAX_NAME, Skeleton, performer_name

MAX_PERFORMERS = 64  # per profile
_GAP_LOW, _GAP_HIGH, _INTERVAL = 0.004, 0.1, 0.04  # s
_GAP_MARKED = 1.0  # s; a mark that is lost is missed no later than at the next frame

NO_POSES: Sequence[Pose] = ()
Parents = Callable[[Sequence[str]], tuple[tuple[int, ...], int]]
Scaled = tuple[NDArray[np.float64], Scale]  # (3,) metres per unit, and how it was found
Scaling = Callable[[NDArray[np.float64]], Scaled]


class SingleJoints:
    """Puts the joints of a profile's performers together to frames.

    Args:
        context: The source as its profiles know it.
        scaling: Takes (n, J, 3) raw positions of the first frames and returns factor (3,) and the scale. The first
            performer of a sender is measured; one sensor has one unit, and the same place is the same for all ids.
        parents: Finds parents and root of named joints.
    """

    def __init__(self, context: Context, scaling: Scaling, parents: Parents = with_known_parents) -> None:
        self._senders = context.senders
        self._scaling = scaling
        self._scales: Newest[str, Scaled] = Newest(MAX_SENDERS)  # by sender
        self._parents = parents
        self._performers: Recent[_Performer] = Recent(MAX_PERFORMERS, "performers")

    def put(self, message: Message, person: str, joint: str, xyzc: Row) -> Sequence[Pose]:
        """Take one joint and return the frames that it completes.

        Args:
            message: The message it came in.
            person: Id of the performer, empty if the protocol has none.
            joint: Name.
            xyzc: Position and confidence (NaN where the protocol has none).

        Raises:
            FrameError: If the performer has too many joints, or is new and there is no room; nothing is changed then.
        """
        return self._performer(message, person).put(_clean(joint), xyzc, message.arrival)

    def put_all(self, message: Message, person: str, rows: Mapping[str, Row]) -> list[Pose]:
        """Take several joints of one message, see `put`."""
        performer = self._performer(message, person)
        performer.note(rows)  # all of them, before anything is changed
        return [pose for joint, row in rows.items() for pose in performer.put(joint, row, message.arrival)]

    def _performer(self, message: Message, person: str) -> "_Performer":
        name = self._senders.name(message.sender, person)
        found = self._performers.hear(name, message.arrival)
        if found is not None:
            return found
        self._performers.make_room(name, message.arrival)
        sender = message.sender
        performer = _Performer(name, sender, lambda raw: self._scaled(sender, raw), self._parents)
        return self._performers.add(name, performer, message.arrival)

    def _scaled(self, sender: str, raw: NDArray[np.float64]) -> Scaled:
        """Return factor and scale of a sender, measured on its first performer whose height can be measured."""
        found = self._scales.get(sender)
        if found is None:
            found = self._scaling(raw)
            if height(raw) > 0:
                self._scales[sender] = found
        return found

    def end_frames(self, message: Message) -> list[Pose]:
        """Return the frames of a sender that marks their end."""
        return [
            pose
            for performer in self._performers.values()
            if performer.sender == message.sender
            for pose in performer.end_frame()
        ]

    def leave(self, message: Message, person: str, reason: str) -> list[Pose | Departure]:
        """Return the last pose of a performer, and its departure."""
        name = self._senders.name(message.sender, person)
        found = self._performers.pop(name).finish() if self._performers.get(name) is not None else ()
        return [*found, Departure(name, reason)]

    def idle(self, now: float) -> list[Pose]:
        """Return the frames that nothing more comes for."""
        return [pose for performer in self._performers.values() for pose in performer.idle(now)]

    def pending(self) -> bool:
        """Return whether a frame is open or held back."""
        return any(performer.pending for performer in self._performers.values())


class _Performer:
    """The frames of one performer."""

    def __init__(self, name: str, sender: str, scaling: Scaling, parents: Parents) -> None:
        self._name, self.sender = name, sender
        self._marked = False  # whether the sender marks the end of frames
        self._scaling, self._parents = scaling, parents
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

    def note(self, joints: Iterable[str]) -> None:
        for joint in joints:
            self._known.note(joint)

    def put(self, joint: str, row: Row, arrival: float) -> Sequence[Pose]:
        self._known.note(joint)  # may refuse it, before anything is changed
        wait = arrival - self.last
        poses = self._close() if self._rows and self._begins(joint, wait) else NO_POSES
        if not self._rows:
            self._open(joint, wait, arrival)
        self._waited = max(self._waited, (wait, joint))
        self._rows[joint] = row
        self.last, self._newest = arrival, joint
        if self._known.learnt and len(self._rows) == len(self._known.names):
            return [*poses, *self._close()]
        return poses

    def idle(self, now: float) -> list[Pose]:
        gap = self._pause if self._newest == self._tail else _GAP_HIGH
        gap = _GAP_MARKED if self._marked else gap
        poses = self._close() if self._rows and now - self.last > gap else []
        return poses + self._posed(self._known.release()) if self._known.overdue(now) else poses

    def end_frame(self) -> Sequence[Pose]:
        """Return the frame whose end is marked, if a joint of it came."""
        self._marked = True
        return self._close() if self._rows else NO_POSES

    def finish(self) -> list[Pose]:
        poses = self._close() if self._rows else []
        return poses + self._posed(self._known.release())

    def _begins(self, joint: str, wait: float) -> bool:
        """Return whether a joint begins a new frame."""
        if joint in self._rows:
            return True
        if self._marked:
            return False
        if joint == self._opener and 2 * len(self._rows) > len(self._known.names):
            return True
        return joint == self._waited_before and wait > max(0.75 * self._interval, _GAP_LOW)

    def _open(self, joint: str, wait: float, arrival: float) -> None:
        if self._opener is None or wait > self._pause:
            self._opener = joint
        if 0 < arrival - self._opened < 1.0:
            self._interval += (arrival - self._opened - self._interval) / 4
        self._opened = arrival

    def _close(self) -> list[Pose]:
        rows, self._rows = self._rows, {}
        self._waited_before, self._waited = self._waited[1], (0.0, "")
        self._tail = self._newest
        return self._posed(self._known.admit(ClosedFrame(rows, self._opened)))

    def _posed(self, frames: Sequence[ClosedFrame]) -> list[Pose]:
        if not frames:
            return []
        tables = np.stack([self._known.table(frame.rows, 4) for frame in frames])  # (n, J, 4)
        if self._factor is None:
            self._factor, scale = self._scaling(tables[:, :, :3])
            self._unit = scale.note or "m"
        if self._skeleton is None or len(self._skeleton) != tables.shape[1]:
            names = tuple(self._known.names)
            self._skeleton = Skeleton(names, *self._parents(names))
        metres = tables[:, :, :3] * self._factor
        return [
            Pose(
                self._name,
                xyz,
                frame.arrival,
                confidence=None if np.isnan(table[:, 3]).all() else table[:, 3],
                skeleton=self._skeleton,
                unit=self._unit,
                sender=self.sender,
            )
            for frame, table, xyz in zip(frames, tables, metres, strict=True)
        ]


def isotropic(choose: Callable[[float], Scale]) -> Scaling:
    """Return a scaling that multiplies all axes alike.

    Args:
        choose: Makes the scale of the height of the skeleton.
    """

    def scaling(positions: NDArray[np.float64]) -> Scaled:
        scale = choose(height(positions))
        return np.full(3, scale.metres), scale

    return scaling


def _clean(joint: str) -> str:
    if 0 < len(joint) <= MAX_NAME and joint.isprintable():
        return joint
    return performer_name(joint)
