"""Profile `osceleton`: OpenNI sensors through OSCeleton and programs that imitate it.

`/joint ,sifff` name, user, x, y, z; `/joint/<name>/<user> ,fff`; `/new_user ,i`, `/lost_user ,i`. Coordinates
are shares of the sensor's field: OSCeleton divides 2.56 m, 1.92 m and 1.28 m along x, y and z. The result is
scaled to a usual height, unless the user states a unit.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.units import Scale, fitted_scale, guessed_scale, height
from mossar_adapters.joint_sets import openni_parents
from mossar_adapters.osc.assembly.single_joints import SingleJoints
from mossar_adapters.osc.messages import numbers, whole_number, word
from mossar_adapters.osc.profiles.profile import NOTHING, Context, Items, Message
from mossar_stream import FrameError

FIELD = (2.56, 1.92, 1.28)  # m per unit along x, y, z
_RAW = 20.0  # coordinates above this are no shares but raw millimetres


class Osceleton:
    """Frames from `/joint` messages."""

    name = "osceleton"

    def __init__(self, context: Context) -> None:
        self._joints = SingleJoints(context, lambda raw: _scaling(raw, context.options), openni_parents)
        self.idle = self._joints.idle
        self.pending = self._joints.pending

    def claims(self, message: Message) -> bool:
        """Return whether the address is one of OSCeleton's."""
        address = message.address
        return address == "/joint" or address.startswith(("/joint/", "/new_user", "/lost_user"))

    def receive(self, message: Message) -> Items:
        """Take a joint, or note that a user left."""
        address, arguments = message.address, message.arguments
        if address == "/joint":
            xyz = numbers(arguments, 2, 3)
            return self._joints.put(
                message, str(whole_number(arguments[1])), word(arguments, 0), (*xyz, np.nan)
            )
        if address.startswith("/joint/"):
            joint, slash, user = address[len("/joint/") :].rpartition("/")
            if not slash or not joint:
                raise FrameError(f"{address[:60]} is not of the form /joint/<name>/<user>")
            return self._joints.put(message, user, joint, (*numbers(arguments, 0, 3), np.nan))
        if address == "/lost_user":
            return self._joints.leave(
                message, str(whole_number(arguments[0] if arguments else None)), "lost user"
            )
        return NOTHING


def _scaling(raw: NDArray[np.float64], options: ReadOptions) -> tuple[NDArray[np.float64], Scale]:
    largest = np.nanmax(np.abs(raw)) if np.isfinite(raw).any() else 0.0
    if largest > _RAW:
        scale = guessed_scale(options, height(raw))
        return np.full(3, scale.metres), scale
    field = np.array(FIELD)
    scale = fitted_scale(options, height(raw * field))
    return field * scale.metres, scale
