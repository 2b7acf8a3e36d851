"""Profile `kinectv2`: Kinect for Xbox One bridges.

`/bodies/<id>/joints/<JointType> ,fffs` x, y, z and `Tracked`, `Inferred` or `NotTracked`; metres.
"""

import numpy as np

from mossar_adapters.files.units import given
from mossar_adapters.osc.assembly.single_joints import People, isotropic
from mossar_adapters.osc.messages import numbers
from mossar_adapters.osc.profiles.profile import Intake, Message
from mossar_stream.errors import FrameError

_CONFIDENCE = {"tracked": 1.0, "inferred": 0.5, "nottracked": 0.0}


class KinectV2:
    """Frames from `/bodies/<id>/joints/<JointType>` messages."""

    name = "kinectv2"

    def __init__(self, intake: Intake) -> None:
        self._people = People(intake, isotropic(lambda _: given(intake.options, 1.0)))
        self.idle = self._people.idle
        self.pending = self._people.pending

    def claims(self, message: Message) -> bool:
        """Return whether the address is that of a body."""
        return message.address.startswith("/bodies/")

    def take(self, message: Message) -> None:
        """Use a joint; hands and other parts of a body are passed over."""
        parts = message.address.split("/")
        if len(parts) != 5 or parts[3] != "joints":
            return
        arguments = message.arguments
        confidence = np.nan
        if len(arguments) > 3 and isinstance(arguments[3], str):
            confidence = _CONFIDENCE.get(arguments[3].lower(), np.nan)
            if np.isnan(confidence):
                raise FrameError(f"{arguments[3][:40]!r} is no tracking state")
        self._people.put(message, parts[2], parts[4], (*numbers(arguments, 0, 3), confidence))
