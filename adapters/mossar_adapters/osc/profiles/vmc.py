"""Profile `vmc`: the Virtual Motion Capture protocol, sent by most avatar programs.

`/VMC/Ext/Bone/Pos ,sfffffff` name, local position, local rotation; `/VMC/Ext/Root/Pos` the same for the whole;
`/VMC/Ext/OK`, `/VMC/Ext/T`. Fingers, eyes, jaw, blend shapes and devices are passed over.
"""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.registry import open_motion
from mossar_adapters.osc.assembly.humanoid import bone_name, rest_of
from mossar_adapters.osc.assembly.known_joints import ClosedFrame, KnownJoints
from mossar_adapters.osc.assembly.vmc_frames import VmcFrames, exact_time
from mossar_adapters.osc.assembly.vmc_pose import BUILT_IN, VmcPose
from mossar_adapters.osc.messages import numbers, word
from mossar_adapters.osc.profiles.profile import Intake, Message
from mossar_stream.errors import FrameError

BONE, ROOT, OK, TIME = "/VMC/Ext/Bone/Pos", "/VMC/Ext/Root/Pos", "/VMC/Ext/OK", "/VMC/Ext/T"
MAX_AVATARS = 64

Rest = Mapping[str, NDArray[np.float64]]


class Vmc:
    """Frames from `/VMC/Ext/…` messages.

    Raises:
        FileError: If the skeleton file that the user names cannot be read.
        SettingsError: If it is no humanoid.
    """

    name = "vmc"

    def __init__(self, intake: Intake) -> None:
        self._intake = intake
        self._rest = _rest(intake)
        self._avatars: dict[str, _Avatar] = {}

    def claims(self, message: Message) -> bool:
        """Return whether the address is one of VMC's."""
        return message.address.startswith("/VMC/")

    def take(self, message: Message) -> None:
        """Use a bone, a root, OK or T."""
        address, arguments = message.address, message.arguments
        if address == BONE:
            bone = bone_name(word(arguments, 0))
            if bone is not None:
                self._avatar(message).frames.bone(bone, _transform(message), message.arrival)
        elif address == ROOT:
            self._avatar(message).frames.root(_transform(message), message.arrival)
        elif address == TIME:
            (seconds,) = numbers(arguments, 0, 1)
            if not math.isfinite(seconds):
                raise FrameError("T is no time")
            self._avatar(message).frames.time(seconds, message.arrival)
        elif address == OK:
            self._avatar(message).frames.ok(message.arrival)

    def idle(self, now: float) -> None:
        """Close the frames that nothing more comes for."""
        for avatar in self._avatars.values():
            avatar.frames.idle(now)
            avatar.release(now)

    def pending(self) -> bool:
        """Return whether a frame is open or held back."""
        return any(avatar.frames.pending or avatar.known.holding for avatar in self._avatars.values())

    def _avatar(self, message: Message) -> "_Avatar":
        name = self._intake.senders.name(message.sender)
        found = self._avatars.get(name)
        if found is None:
            if len(self._avatars) == MAX_AVATARS:
                del self._avatars[min(self._avatars, key=lambda key: self._avatars[key].frames.last)]
            found = self._avatars[name] = _Avatar(name, self._intake, self._rest)
        return found


class _Avatar:
    """The frames of one sender."""

    def __init__(self, name: str, intake: Intake, rest: Rest | None) -> None:
        self._name, self._intake, self._rest = name, intake, rest
        self._pose: VmcPose | None = None
        self._ahead: float | None = None  # sender's time minus arrival, s, in its latest frame with a T
        self.known = KnownJoints()
        self.frames = VmcFrames(self._closed)

    def release(self, now: float) -> None:
        if self.known.overdue(now):
            self._emit(list(self.known.release()))

    def _closed(self, closed: ClosedFrame) -> None:
        for bone in closed.rows:
            self.known.note(bone)
        self._emit(list(self.known.admit(closed)))

    def _emit(self, frames: list[ClosedFrame]) -> None:
        if not frames:
            return
        if self._pose is None or len(self._pose.skeleton) != len(self.known.names):
            forced = self._rest is not None
            self._pose = VmcPose(list(self.known.names), self._rest or BUILT_IN, forced=forced)
        for frame in reversed(frames):
            frame.time = self._clock(frame)
        for frame in frames:
            positions = self._pose.positions(self.known.table(frame.rows, 7), frame.root)
            self._intake.frame(self._name, self._pose.skeleton, positions, frame.arrival, time=frame.time)

    def _clock(self, frame: ClosedFrame) -> float | None:
        """Return the frame's time on the sender's clock, also where a single T was lost."""
        if frame.time is not None:
            exact = exact_time(frame.time, self._intake.options.fps)
            self._ahead = exact - frame.arrival
            return exact
        return None if self._ahead is None else frame.arrival + self._ahead


def _transform(message: Message) -> tuple[float, ...]:
    start = 1 if message.arguments and isinstance(message.arguments[0], str) else 0
    row = numbers(message.arguments, start, 7)
    if not sum(q * q for q in row[3:]) > 1e-12:  # NaN as well
        raise FrameError("a rotation is no quaternion")
    return row


def _rest(intake: Intake) -> Rest | None:
    path = intake.options.skeleton
    if path is None:
        return None
    motion = open_motion(path, ReadOptions(unit=intake.options.unit))
    rest = rest_of(motion)
    if not rest:
        raise intake.address.error(f"the joints of {path} are not called like those of a humanoid")
    return rest
