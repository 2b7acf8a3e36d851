"""Profile `generic`: addresses and arguments as the user describes them.

`?pattern=/pose/{performer}/{joint}` describes the address, `&args=xyzc` the arguments: `x` `y` `z`, `c` confidence, `j` name of the joint, `p` performer, `_` something else.
"""

import re
from typing import Any

import numpy as np

from mossar_adapters.address import Address
from mossar_adapters.files.units import guessed_scale
from mossar_adapters.osc.assembly.single_joints import SingleJoints, isotropic
from mossar_adapters.osc.messages import numbers_at
from mossar_adapters.osc.profiles.profile import Context, Items, Message
from mossar_stream import FrameError

OPTIONS = {
    "pattern": "address with placeholders: /pose/{performer}/{joint}",
    "args": "arguments: x y z, c confidence, j joint, p performer, _ other; default xyz",
}
_PLACES = {"{performer}": r"(?P<performer>[^/]{1,64})", "{joint}": r"(?P<joint>[^/]{1,120})"}
_MAX_ADDRESSES = 4096  # remembered
_PART = re.compile(r"(\{[^}]*\})")


class Generic:
    """Frames from messages of any form that carry one joint each.

    Raises:
        SettingsError: If pattern or args cannot be used.
    """

    name = "generic"

    def __init__(self, context: Context) -> None:
        self._joints = SingleJoints(context, isotropic(lambda tall: guessed_scale(context.options, tall)))
        self._pattern = _compiled(checked_pattern(context.address))
        self._args = checked_args(context.address)
        self._places = [self._args.index(letter) for letter in "xyzc" if letter in self._args]
        self._names: dict[str, tuple[str, str]] = {}  # address -> performer and joint in it
        self.idle = self._joints.idle
        self.pending = self._joints.pending

    def claims(self, message: Message) -> bool:
        """Return whether the address has the form."""
        return message.address in self._names or self._pattern.fullmatch(message.address) is not None

    def receive(self, message: Message) -> Items:
        """Take a joint."""
        performer, joint = self._names.get(message.address) or self._parts(message.address)
        if "p" in self._args:
            performer = self._text(message, "p")
        if "j" in self._args:
            joint = self._text(message, "j")
        row = numbers_at(message.arguments, self._places)
        return self._joints.put(message, performer, joint, row if len(row) == 4 else (*row, np.nan))

    def _parts(self, address: str) -> tuple[str, str]:
        """Return performer and joint in an address, empty where the pattern has none."""
        match = self._pattern.fullmatch(address)
        if match is None:
            raise FrameError(f"{address[:60]} does not fit the pattern")
        found = match.groupdict()
        parts = (found.get("performer", ""), found.get("joint", ""))
        if len(self._names) < _MAX_ADDRESSES:
            self._names[address] = parts
        return parts

    def _text(self, message: Message, letter: str) -> str:
        place = self._args.index(letter)
        if place >= len(message.arguments):
            raise FrameError(f"{len(message.arguments)} arguments are too few for args={self._args}")
        value: Any = message.arguments[place]
        return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def checked_pattern(address: Address) -> str:
    """Return the option `pattern`.

    Raises:
        SettingsError: If it is missing or holds something unknown.
    """
    text = address.options.get("pattern")
    if text is None or not text.startswith("/") or len(text) > 200:
        raise address.error("profile generic needs pattern=/pose/{performer}/{joint}, or one like it")
    for part in _PART.findall(text):
        if part not in _PLACES or text.count(part) > 1:
            raise address.error(f"pattern may hold {{performer}} and {{joint}}, once each, not {part[:40]}")
    return text


def checked_args(address: Address) -> str:
    """Return the option `args`.

    Raises:
        SettingsError: If it holds something unknown, or the joint's name stands nowhere or twice.
    """
    text = address.options.get("args", "xyz")
    letters = text.replace("_", "")
    if not set("xyz") <= set(letters) <= set("xyzcjp") or len(set(letters)) < len(letters) or len(text) > 64:
        raise address.error("args holds x, y and z once each, and perhaps c, j, p or _, as in args=xyzc")
    if ("{joint}" in address.options.get("pattern", "")) == ("j" in text):
        raise address.error("the joint's name stands either in pattern ({joint}) or in args (j)")
    return text


def _compiled(pattern: str) -> re.Pattern[str]:
    parts = _PART.split(pattern)
    return re.compile("".join(_PLACES[p] if p in _PLACES else re.escape(p) for p in parts))
