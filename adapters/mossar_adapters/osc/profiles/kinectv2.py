"""Profile `kinectv2`: Kinect for Xbox One bridges.

`/bodies/<id>/joints/<JointType> ,fffs` x, y, z and `Tracked`, `Inferred` or `NotTracked`; metres.
"""

import numpy as np

from mossar_adapters.files.units import stated_scale
from mossar_adapters.osc.assembly.single_joints import SingleJoints, isotropic
from mossar_adapters.osc.messages import numbers
from mossar_adapters.osc.profiles.profile import NOTHING, Context, Items, Message
from mossar_stream import FrameError

_CONFIDENCE = {"tracked": 1.0, "inferred": 0.5, "nottracked": 0.0}


class KinectV2:
    """Frames from `/bodies/<id>/joints/<JointType>` messages."""

    name = "kinectv2"

    def __init__(self, context: Context) -> None:
        self._joints = SingleJoints(context, isotropic(lambda _: stated_scale(context.options, 1.0)))
        self.idle = self._joints.idle
        self.pending = self._joints.pending

    def claims(self, message: Message) -> bool:
        """Return whether the address is that of a body."""
        return message.address.startswith("/bodies/")

    def receive(self, message: Message) -> Items:
        """Take a joint; hands and other parts of a body are passed over."""
        parts = message.address.split("/")
        if len(parts) != 5 or parts[3] != "joints":
            return NOTHING
        arguments = message.arguments
        confidence = np.nan
        if len(arguments) > 3 and isinstance(arguments[3], str):
            confidence = _CONFIDENCE.get(arguments[3].lower(), np.nan)
            if np.isnan(confidence):
                raise FrameError(f"{arguments[3][:40]!r} is no tracking state")
        return self._joints.put(message, parts[2], parts[4], (*numbers(arguments, 0, 3), confidence))
