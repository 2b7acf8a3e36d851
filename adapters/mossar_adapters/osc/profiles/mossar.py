"""Profile `mossar`: our own messages, which keep names, order and time.

`/mossar/meta ,ss…` performer, joint names, and as an integer the index of the body centre (-1: the centroid)
where the names do not imply it; `/mossar/frame ,sidb` performer, seq, t, a blob of big-endian float32 x y z per
joint.
"""

import numpy as np

from mossar_adapters.joint_sets import printable_names, with_known_parents
from mossar_adapters.osc.messages import numbers, whole_number, word
from mossar_adapters.osc.profiles.profile import NOTHING, Context, Items, Message
from mossar_adapters.receiving.names import distinct_name
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.receiving.sequence import Sequences
from mossar_adapters.source import Meta
from mossar_stream import MAX_JOINTS, FrameError, Skeleton

META, FRAME = "/mossar/meta", "/mossar/frame"


class Mossar:
    """Frames from `/mossar/frame` messages."""

    name = "mossar"

    def __init__(self, context: Context) -> None:
        self._context = context
        self._sequences = Sequences(context.counters)

    def claims(self, message: Message) -> bool:
        """Return whether the address is one of ours."""
        return message.address in {META, FRAME}

    def receive(self, message: Message) -> Items:
        """Take a meta or a frame."""
        if message.address == META:
            return (self._meta(message),)
        return (self._pose(message),) if message.address == FRAME else NOTHING

    def idle(self, now: float) -> Items:  # noqa: ARG002 - as other profiles have it
        """Return nothing: every message is a whole frame."""
        return NOTHING

    def pending(self) -> bool:
        """Return False: nothing is ever held back."""
        return False

    def _meta(self, message: Message) -> Meta:
        arguments = list(message.arguments)
        stated = whole_number(arguments.pop()) if arguments and not isinstance(arguments[-1], str) else None
        words = [word(arguments, place) for place in range(len(arguments))]
        if len(words) < 2:
            raise FrameError("a meta has a performer and the names of the joints")
        parents, root = with_known_parents(words[1:])
        skeleton = printable_names(Skeleton(tuple(words[1:]), parents, root if stated is None else stated))
        return Meta(self._name(message, words[0]), skeleton, self._context.options.fps)

    def _pose(self, message: Message) -> Pose:
        arguments = message.arguments
        name = self._name(message, word(arguments, 0))
        (time,) = numbers(arguments, 2, 1)
        blob = arguments[3] if len(arguments) > 3 else None
        if not isinstance(blob, bytes) or len(blob) % 12 or not 12 <= len(blob) <= 12 * MAX_JOINTS:
            raise FrameError("a frame has performer, seq, t and a blob of 12 bytes per joint")
        self._sequences.count(name, whole_number(arguments[1]))
        positions = np.frombuffer(blob, ">f4").reshape(-1, 3).astype(np.float32)
        return Pose(name, positions, message.arrival, time)

    def _name(self, message: Message, person: str) -> str:
        if message.sender or "performer" in self._context.address.options:
            return self._context.senders.name(message.sender, person)
        return distinct_name(person)
