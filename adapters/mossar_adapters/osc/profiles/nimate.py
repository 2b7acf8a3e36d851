"""Profile `nimate`: NI mate's default addresses.

NI mate 2 in format "Basic" sends `Right_Hand ,fff`, without a slash, or `Right_Hand_2` where it tracks several users, and
`/NI_mate_sync` after each frame. Users are numbered from 1, or the first one has no number. Older versions:

`/skeleton_left_hand ,fff` x, y, z, perhaps followed by an orientation, which is passed over; "omni" sends all
joints in one message `/skeleton` without names. Coordinates are metres or millimetres. Addresses are editable there: others need `profile=generic`.
"""

import re

import numpy as np

from mossar_adapters.files.units import guessed_scale
from mossar_adapters.joint_sets import openni_parents
from mossar_adapters.newest import Newest
from mossar_adapters.osc.assembly.known_joints import MAX_NAMES
from mossar_adapters.osc.assembly.single_joints import SingleJoints, isotropic
from mossar_adapters.osc.messages import numbers
from mossar_adapters.osc.profiles.profile import NOTHING, Context, Items, Message
from mossar_adapters.receiving.senders import MAX_SENDERS
from mossar_stream import FrameError

_ADDRESS = re.compile(r"/(?:(?P<person>[^/]{1,40})/)?skeleton[_/](?P<joint>[^/]{1,60})")
_BASIC = re.compile(r"(?P<joint>[A-Za-z][^/]{0,60}?)(?:_(?P<person>\d{1,4}))?")
_NUMBERED = re.compile(
    r"(?P<joint>(?:left|right)_[a-z]{1,20}|head|neck|torso|waist|pelvis|hips)_(?P<person>\d{1,4})",
    re.IGNORECASE,
)
_SYNC = ("/NI_mate_sync", "NI_mate_sync")
_PLACES = (3, 7)  # numbers of a place, and of a place and an orientation; others are no places
_OMNI = re.compile(r"/(?:(?P<person>[^/]{1,40})/)?skeleton")


class NiMate:
    """Frames from `/skeleton_<joint>` or `/skeleton` messages."""

    name = "nimate"

    def __init__(self, context: Context) -> None:
        self._joints = SingleJoints(
            context, isotropic(lambda tall: guessed_scale(context.options, tall)), openni_parents
        )
        # Plain, and 1, of each sender that has them.
        self._numbers: Newest[str, set[str]] = Newest(MAX_SENDERS)
        self.idle = self._joints.idle
        self.pending = self._joints.pending

    def claims(self, message: Message) -> bool:
        """Return whether the address is one of NI mate's defaults."""
        if message.address[:1] != "/" or message.address in _SYNC:
            return message.address in _SYNC or _BASIC.fullmatch(message.address) is not None
        return "/skeleton" in message.address and (
            _ADDRESS.fullmatch(message.address) is not None or _OMNI.fullmatch(message.address) is not None
        )

    def receive(self, message: Message) -> Items:
        """Take a joint, all of them, or the end of a frame."""
        if message.address in _SYNC:
            return self._joints.end_frames(message)
        if message.address[:1] != "/" and (basic := _BASIC.fullmatch(message.address)):
            if len(message.arguments) not in _PLACES:
                return NOTHING
            xyz = numbers(message.arguments, 0, 3)
            person = self._person(message.sender, basic["person"] or "")
            return self._joints.put(message, person, basic["joint"], (*xyz, np.nan))
        if single := _ADDRESS.fullmatch(message.address):
            xyz = numbers(message.arguments, 0, 3)
            person, joint = single["person"] or "", single["joint"]
            if not person:
                numbered = _NUMBERED.fullmatch(joint)
                person = self._person(message.sender, numbered["person"] if numbered else "")
                joint = numbered["joint"] if numbered else joint
            return self._joints.put(message, person, joint, (*xyz, np.nan))
        if omni := _OMNI.fullmatch(message.address):
            count = len(message.arguments)
            if count == 0 or count % 3 or count > 3 * MAX_NAMES:
                raise FrameError(f"{count} arguments are not x y z of joints")
            values = numbers(message.arguments, 0, count)
            rows = {f"joint{i // 3}": (*values[i : i + 3], np.nan) for i in range(0, count, 3)}
            return self._joints.put_all(message, omni["person"] or "", rows)
        return NOTHING

    def _person(self, sender: str, number: str) -> str:
        """Return the id of a user: one more than its number where there is one without a number, too."""
        seen = self._numbers.get(sender)
        if seen is None:
            seen = self._numbers[sender] = set()
        if number in {"", "1"}:
            seen.add(number)
        return str(int(number) + 1) if number and len(seen) > 1 else number
