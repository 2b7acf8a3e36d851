"""Profile `nimate`: NI mate's default addresses.

`/skeleton_left_hand ,fff` x, y, z, perhaps followed by an orientation, which is passed over; "omni" sends all
joints in one message `/skeleton` without names. Addresses are editable there: others need `profile=generic`.
"""

import re

import numpy as np

from mossar_adapters.files.units import guessed_scale
from mossar_adapters.joint_sets import openni_parents
from mossar_adapters.osc.assembly.known_joints import MAX_NAMES
from mossar_adapters.osc.assembly.single_joints import SingleJoints, isotropic
from mossar_adapters.osc.messages import numbers
from mossar_adapters.osc.profiles.profile import NOTHING, Context, Items, Message
from mossar_stream import FrameError

_ADDRESS = re.compile(r"/(?:(?P<person>[^/]{1,40})/)?skeleton[_/](?P<joint>[^/]{1,60})")
_OMNI = re.compile(r"/(?:(?P<person>[^/]{1,40})/)?skeleton")


class NiMate:
    """Frames from `/skeleton_<joint>` or `/skeleton` messages."""

    name = "nimate"

    def __init__(self, context: Context) -> None:
        self._joints = SingleJoints(
            context, isotropic(lambda tall: guessed_scale(context.options, tall)), openni_parents
        )
        self.idle = self._joints.idle
        self.pending = self._joints.pending

    def claims(self, message: Message) -> bool:
        """Return whether the address is one of NI mate's defaults."""
        return "/skeleton" in message.address and (
            _ADDRESS.fullmatch(message.address) is not None or _OMNI.fullmatch(message.address) is not None
        )

    def receive(self, message: Message) -> Items:
        """Take a joint, or all of them."""
        if single := _ADDRESS.fullmatch(message.address):
            xyz = numbers(message.arguments, 0, 3)
            return self._joints.put(message, single["person"] or "", single["joint"], (*xyz, np.nan))
        if omni := _OMNI.fullmatch(message.address):
            count = len(message.arguments)
            if count == 0 or count % 3 or count > 3 * MAX_NAMES:
                raise FrameError(f"{count} arguments are not x y z of joints")
            values = numbers(message.arguments, 0, count)
            rows = {f"joint{i // 3}": (*values[i : i + 3], np.nan) for i in range(0, count, 3)}
            return self._joints.put_all(message, omni["person"] or "", rows)
        return NOTHING
