"""Profile `flat`: one message is one frame, an array of x y z or x y z confidence per joint.

MediaPipe-to-OSC scripts and the like. The array may begin with the number of joints or of people; a single 0
means no person. Their number, or `?joints=coco17`, determines the set of joints.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import METRES
from mossar_adapters.files.units import Scale, fitted_scale, guessed_scale, height
from mossar_adapters.joint_sets import JOINT_SETS, by_count
from mossar_adapters.osc.messages import numbers
from mossar_adapters.osc.profiles.profile import NOTHING, Context, Items, Message
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.source import Departure
from mossar_stream import MAX_JOINTS, FrameError, Skeleton

OPTIONS = {
    "stride": "3 (x y z) or 4 (x y z confidence)",
    "joints": f"which joints: {', '.join(JOINT_SETS)}",
}
_USUAL = (33, 17, 25)  # joints of the usual pose estimators
_MAX_PEOPLE = 16
_MIN_NUMBERS = 51  # arrays shorter than 17 joints are something else to `auto`


class Layout:
    """Division of arrays into people and joints.

    Args:
        stride: 3 or 4 numbers per joint, or None to find out.
        joints: Number of joints, or None to find out.
    """

    def __init__(self, stride: int | None = None, joints: int | None = None) -> None:
        self._strides = (stride,) if stride else (3, 4)
        self._joints = joints

    def cut(self, values: Sequence[float]) -> tuple[int, int, int, int] | None:
        """Return (place of the first number, people, joints, stride), or None if the array does not fit."""
        count = len(values)
        known = [(j, s) for j in ((self._joints,) if self._joints else _USUAL) for s in self._strides]
        first, rest = values[0], count - 1
        if first == int(first) if first == first else False:  # noqa: PLR0124 - NaN is not itself
            for joints, stride in known:
                if 1 <= first <= _MAX_PEOPLE and rest == first * joints * stride:
                    return 1, int(first), joints, stride
            for stride in self._strides:
                if first > 1 and rest == first * stride and self._joints in {None, first}:
                    return 1, 1, int(first), stride
        for joints, stride in known:
            if count == joints * stride:
                return 0, 1, joints, stride
        if self._joints is None:
            for stride in self._strides:
                if count % stride == 0:
                    return 0, 1, count // stride, stride
        return None

    def usual(self, count: int) -> bool:
        """Return whether an array of so many numbers can be a pose of a usual set of joints."""
        return any((count - lead) in {j * s for j in _USUAL for s in (3, 4)} for lead in (0, 1))


class Flat:
    """Frames from messages that hold whole poses."""

    name = "flat"

    def __init__(self, context: Context) -> None:
        address = context.address
        names = tuple(JOINT_SETS)
        self._known: Skeleton | None = None
        if "joints" in address.options:
            self._known = JOINT_SETS[address.choice("joints", names, "")]
        stride = int(address.choice("stride", ("3", "4"), "3")) if "stride" in address.options else None
        self._chosen = address.options.get("profile") == "flat"
        self._layout = Layout(stride, len(self._known) if self._known else None)
        self._context = context
        self._skeletons: dict[int, Skeleton] = {}
        self._scales: dict[str, Scale] = {}
        self._present: dict[str, int] = {}  # people in the latest message of an address

    def claims(self, message: Message) -> bool:
        """Return whether these are as many numbers as a usual pose has; any, if the user chose this profile."""
        arguments = _flattened(message.arguments)
        if message.address in self._present and _nobody(arguments):
            return True
        if self._chosen:
            return bool(arguments)
        if len(arguments) < _MIN_NUMBERS or not self._layout.usual(len(arguments)):
            return False
        return all(type(value) in {float, int} for value in arguments)

    def receive(self, message: Message) -> Items:
        """Process a frame, or note that no person is present."""
        arguments = _flattened(message.arguments)
        if _nobody(arguments):
            return self._gone(message, 0)
        if not 3 <= len(arguments) <= 4 * MAX_JOINTS + 1:
            raise FrameError(f"{len(arguments)} numbers are no pose")
        values = numbers(arguments, 0, len(arguments))
        cut = self._layout.cut(values)
        if cut is None:
            raise FrameError(f"{len(values)} numbers do not fit the joints; set stride= and joints=")
        start, people, joints, stride = cut
        table = np.array(values[start:]).reshape(people, joints, stride)
        poses = [self._pose(message, self._person(message, i), table[i]) for i in range(people)]
        return [*poses, *self._gone(message, people)]

    def idle(self, now: float) -> Items:  # noqa: ARG002 - as other profiles have it
        """Return nothing: every message is a whole frame."""
        return NOTHING

    def pending(self) -> bool:
        """Return False: nothing is ever held back."""
        return False

    def _person(self, message: Message, person: int) -> str:
        return self._context.senders.name(message.sender, str(person + 1) if person else "")

    def _pose(self, message: Message, performer: str, table: NDArray[np.float64]) -> Pose:
        xyz = table[:, :3]
        scale = self._scales.get(performer)
        if scale is None:
            scale = self._scale(height(xyz[None]), float(np.nanmax(np.abs(xyz), initial=0.0)))
            if len(self._scales) < 1024:
                self._scales[performer] = scale
        return Pose(
            performer,
            xyz * scale.metres,
            message.arrival,
            confidence=table[:, 3] if table.shape[1] == 4 else None,
            skeleton=self._skeleton(len(table)),
            unit=scale.note or "m",
            sender=message.sender,
        )

    def _scale(self, tall: float, largest: float) -> Scale:
        options = self._context.options
        if options.unit in METRES:
            return Scale(METRES[options.unit])
        if largest <= 1.5 and not 1.2 <= tall <= 2.3:  # shares of the picture, not metres
            return fitted_scale(options, tall)
        return guessed_scale(options, tall)

    def _skeleton(self, joints: int) -> Skeleton:
        if self._known is not None:
            return self._known
        found = self._skeletons.get(joints)
        if found is None:
            plain = Skeleton(tuple(f"joint{i}" for i in range(joints)), root=-1)
            found = self._skeletons[joints] = by_count(joints) or plain
        return found

    def _gone(self, message: Message, people: int) -> list[Departure]:
        """Return the people that were in the message before and are not in this one."""
        before = self._present.get(message.address, 0)
        if message.address in self._present or len(self._present) < 64:
            self._present[message.address] = people
        return [Departure(self._person(message, i), "nobody is there") for i in range(people, before)]


def _nobody(arguments: Sequence[Any]) -> bool:
    return len(arguments) == 1 and arguments[0] == 0


def _flattened(arguments: Sequence[Any]) -> Sequence[Any]:
    """Return the arguments with an OSC array that holds them all opened."""
    return arguments[0] if len(arguments) == 1 and isinstance(arguments[0], list) else arguments
