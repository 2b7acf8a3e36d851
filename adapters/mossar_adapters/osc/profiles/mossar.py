"""Profile `mossar`: our own messages, which keep names, order and time.

`/mossar/meta ,ss…` performer, joint names, and as an integer the index of the body centre (-1: the centroid)
where the names do not tell it; `/mossar/frame ,sidb` performer, seq, t, a blob of big-endian float32 x y z per
joint.
"""

import numpy as np

from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.osc.messages import numbers, whole_number, word
from mossar_adapters.osc.profiles.profile import Intake, Message
from mossar_adapters.receiving.sequence import Sequences
from mossar_stream.errors import FrameError
from mossar_stream.frames import performer_name
from mossar_stream.skeleton import MAX_JOINTS, Skeleton

META, FRAME = "/mossar/meta", "/mossar/frame"
_MAX_KNOWN = 256


class Mossar:
    """Frames from `/mossar/frame` messages."""

    name = "mossar"

    def __init__(self, intake: Intake) -> None:
        self._intake = intake
        self._skeletons: dict[str, Skeleton] = {}
        self._sequences = Sequences(intake.counters)

    def claims(self, message: Message) -> bool:
        """Return whether the address is one of ours."""
        return message.address in {META, FRAME}

    def take(self, message: Message) -> None:
        """Use a meta or a frame."""
        if message.address == META:
            self._meta(message)
        elif message.address == FRAME:
            self._frame(message)

    def idle(self, now: float) -> None:
        """Do nothing: every message is a whole frame."""

    def pending(self) -> bool:
        """Return False: nothing is ever held back."""
        return False

    def _meta(self, message: Message) -> None:
        arguments = list(message.arguments)
        stated = whole_number(arguments.pop()) if arguments and not isinstance(arguments[-1], str) else None
        words = [word(arguments, place) for place in range(len(arguments))]
        if len(words) < 2:
            raise FrameError("a meta has a performer and the names of the joints")
        parents, root = with_known_parents(words[1:])
        skeleton = Skeleton(tuple(words[1:]), parents, root if stated is None else stated)
        name = self._name(message, words[0])
        if self._skeletons.get(name) != skeleton:
            self._remember(name, skeleton)

    def _frame(self, message: Message) -> None:
        arguments = message.arguments
        name = self._name(message, word(arguments, 0))
        (time,) = numbers(arguments, 2, 1)
        blob = arguments[3] if len(arguments) > 3 else None
        if not isinstance(blob, bytes) or len(blob) % 12 or not 12 <= len(blob) <= 12 * MAX_JOINTS:
            raise FrameError("a frame has performer, seq, t and a blob of 12 bytes per joint")
        positions = np.frombuffer(blob, ">f4").reshape(-1, 3).astype(np.float32)
        skeleton = self._skeletons.get(name)
        if skeleton is None:
            skeleton = Skeleton(tuple(f"joint{i}" for i in range(len(positions))), root=-1)
            self._remember(name, skeleton)
        self._sequences.count(name, whole_number(arguments[1]))
        self._intake.frame(name, skeleton, positions, message.arrival, time=time)

    def _name(self, message: Message, person: str) -> str:
        if message.sender or "performer" in self._intake.address.options:
            return self._intake.senders.name(message.sender, person)
        return performer_name(person)

    def _remember(self, name: str, skeleton: Skeleton) -> None:
        if len(self._skeletons) == _MAX_KNOWN:
            del self._skeletons[next(iter(self._skeletons))]
        self._skeletons[name] = skeleton
