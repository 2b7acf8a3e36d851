"""Profile `vmc`: the Virtual Motion Capture protocol, sent by most avatar programs.

`/VMC/Ext/Bone/Pos ,sfffffff` name, local position, local rotation; `/VMC/Ext/Root/Pos` the same for the whole;
`/VMC/Ext/OK`, `/VMC/Ext/T`. Fingers, eyes, jaw, blend shapes and devices are passed over.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.registry import open_motion
from mossar_adapters.osc.assembly.humanoid import bone_name, rest_of
from mossar_adapters.osc.assembly.known_joints import ClosedFrame, KnownJoints, Row
from mossar_adapters.osc.assembly.vmc_frames import VmcFrames, exact_time
from mossar_adapters.osc.assembly.vmc_pose import BUILT_IN, VmcPose
from mossar_adapters.osc.messages import numbers, word
from mossar_adapters.osc.profiles.profile import NOTHING, Context, Items, Message
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.receiving.recent import Recent
from mossar_stream import FrameError

BONE, ROOT, OK, TIME = "/VMC/Ext/Bone/Pos", "/VMC/Ext/Root/Pos", "/VMC/Ext/OK", "/VMC/Ext/T"
MAX_AVATARS = 64
HELD = 0.5  # s that a bone which does not come keeps its transform, as avatars do,
_OFTEN = 0.2  # where more than this share of frames lack bones: a single loss is for the core to judge
_LONG_RUN = 16  # frames, of that share
_ENOUGH = 3  # frames that have waited together, for a share

Rest = Mapping[str, NDArray[np.float64]]


class Vmc:
    """Frames from `/VMC/Ext/…` messages.

    Raises:
        FileError: If the skeleton file that the user names cannot be read.
        SettingsError: If it is no humanoid.
    """

    name = "vmc"

    def __init__(self, context: Context) -> None:
        self._context = context
        self._rest = _rest(context)
        self._avatars: Recent[_Avatar] = Recent(MAX_AVATARS, "avatars")

    def claims(self, message: Message) -> bool:
        """Return whether the address is one of VMC's."""
        return message.address.startswith("/VMC/")

    def receive(self, message: Message) -> Items:
        """Take a bone, a root, OK or T."""
        address, arguments, arrival = message.address, message.arguments, message.arrival
        if address == BONE:
            bone = bone_name(word(arguments, 0))
            if bone is None:
                return NOTHING
            row, avatar = _transform(message), self._avatar(message)
            return avatar.poses(avatar.frames.bone(bone, row, arrival))
        if address == ROOT:
            row, avatar = _transform(message), self._avatar(message)
            return avatar.poses(avatar.frames.root(row, arrival))
        if address == TIME:
            (seconds,) = numbers(arguments, 0, 1)
            if not math.isfinite(seconds):
                raise FrameError("T is no time")
            avatar = self._avatar(message)
            return avatar.poses(avatar.frames.time(seconds, arrival))
        if address == OK:
            avatar = self._avatar(message)
            return avatar.poses(avatar.frames.ok(arrival))
        return NOTHING

    def idle(self, now: float) -> Items:
        """Return the frames that nothing more comes for."""
        return [pose for avatar in self._avatars.values() for pose in avatar.idle(now)]

    def pending(self) -> bool:
        """Return whether a frame is open or held back."""
        return any(avatar.frames.pending or avatar.known.holding for avatar in self._avatars.values())

    def _avatar(self, message: Message) -> "_Avatar":
        name = self._context.senders.name(message.sender)
        found = self._avatars.hear(name, message.arrival)
        if found is not None:
            return found
        self._avatars.make_room(name, message.arrival)
        avatar = _Avatar(name, message.sender, self._context, self._rest)
        return self._avatars.add(name, avatar, message.arrival)


class _Avatar:
    """The frames of one sender."""

    def __init__(self, name: str, sender: str, context: Context, rest: Rest | None) -> None:
        self._name, self._sender, self._fps, self._rest = name, sender, context.options.fps, rest
        self._pose: VmcPose | None = None
        self._ahead: float | None = None  # sender's time minus arrival, s, in its latest frame with a T
        self._lacking = 0.0  # share of frames that lack bones, smoothed
        self._latest: dict[str, tuple[Row, float]] = {}  # of each bone: its transform, and when it came (s)
        self.known = KnownJoints()
        self.frames = VmcFrames()

    def poses(self, closed: Sequence[ClosedFrame]) -> list[Pose]:
        """Return the poses of frames that are closed, as far as they may go on."""
        ready: list[ClosedFrame] = []
        for frame in closed:
            for bone in frame.rows:
                self.known.note(bone)
            ready += self.known.admit(frame)
        return self._posed(ready)

    def idle(self, now: float) -> list[Pose]:
        found = self.poses(self.frames.idle(now))
        return found + self._posed(self.known.release()) if self.known.overdue(now) else found

    def _posed(self, frames: Sequence[ClosedFrame]) -> list[Pose]:
        if not frames:
            return []
        if self._pose is None or len(self._pose.skeleton) != len(self.known.names):
            forced = self._rest is not None
            self._pose = VmcPose(list(self.known.names), self._rest or BUILT_IN, forced=forced)
        if len(frames) >= _ENOUGH:
            self._lacking = sum(map(self._lacks, frames)) / len(frames)
        for frame in reversed(frames):
            frame.time = self._clock(frame)
        positions = [
            self._pose.positions(self.known.table(self._completed(frame), 7), frame.root) for frame in frames
        ]
        return [
            Pose(
                self._name,
                xyz,
                frame.arrival,
                frame.time,
                skeleton=self._pose.skeleton,
                sender=self._sender,
            )
            for frame, xyz in zip(frames, positions, strict=True)
        ]

    def _lacks(self, frame: ClosedFrame) -> bool:
        return len(frame.rows) < len(self.known.names)

    def _completed(self, frame: ClosedFrame) -> dict[str, Row]:
        """Return the bones of a frame, with the last values of those that it lacks."""
        rows = frame.rows
        self._lacking += (self._lacks(frame) - self._lacking) / _LONG_RUN
        if self._lacking > _OFTEN and self._lacks(frame):
            recent = {bone: row for bone, (row, came) in self._latest.items() if frame.arrival - came <= HELD}
            rows = recent | rows
        self._latest.update({bone: (row, frame.arrival) for bone, row in frame.rows.items()})
        return rows

    def _clock(self, frame: ClosedFrame) -> float | None:
        """Return the frame's time on the sender's clock, also where a single T was lost."""
        if frame.time is not None:
            exact = exact_time(frame.time, self._fps)
            self._ahead = exact - frame.arrival
            return exact
        return None if self._ahead is None else frame.arrival + self._ahead


def _transform(message: Message) -> tuple[float, ...]:
    start = 1 if message.arguments and isinstance(message.arguments[0], str) else 0
    row = numbers(message.arguments, start, 7)
    if not sum(q * q for q in row[3:]) > 1e-12:  # NaN as well
        raise FrameError("a rotation is no quaternion")
    return row


def _rest(context: Context) -> Rest | None:
    path = context.options.skeleton
    if path is None:
        return None
    motion = open_motion(path, ReadOptions(unit=context.options.unit))
    rest = rest_of(motion)
    if not rest:
        raise context.address.error(f"the joints of {path} are not called like those of a humanoid")
    return rest
