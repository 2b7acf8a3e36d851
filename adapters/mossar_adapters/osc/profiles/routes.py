"""The OSC profiles in one table, and `auto`, which recognises them."""

from collections.abc import Callable

from mossar_adapters.osc.profiles import flat, generic
from mossar_adapters.osc.profiles.flat import Flat
from mossar_adapters.osc.profiles.generic import Generic
from mossar_adapters.osc.profiles.kinectv2 import KinectV2
from mossar_adapters.osc.profiles.mossar import Mossar
from mossar_adapters.osc.profiles.nimate import NiMate
from mossar_adapters.osc.profiles.osceleton import Osceleton
from mossar_adapters.osc.profiles.profile import Context, Items, Message, Profile
from mossar_adapters.osc.profiles.vmc import Vmc

# In the order in which `auto` asks them.
PROFILES: dict[str, Callable[[Context], Profile]] = {
    "mossar": Mossar,
    "vmc": Vmc,
    "osceleton": Osceleton,
    "kinectv2": KinectV2,
    "nimate": NiMate,
    "flat": Flat,
    "generic": Generic,
}
NAMES = ("auto", *PROFILES)
OPTIONS = {
    "profile": f"one of {', '.join(NAMES)}",
    "fps": "rate in Hz: frames without a time of their own are spaced evenly",
    "unit": "m, cm, mm, inch or auto",
    "performer": "name of the performer",
    "skeleton": "a BVH file with the rest skeleton (vmc)",
    "allow": "IP numbers or networks that may send",
    **generic.OPTIONS,
    **flat.OPTIONS,
}
_MAX_ADDRESSES = 4096  # remembered
_LONGEST = 256  # characters of an address that is remembered
_AUTO = tuple(name for name in PROFILES if name != "generic")  # which needs options


class Routes:
    """Hands messages to the profile they fit.

    Args:
        chosen: The user's choice; `auto` makes every profile that needs no options.
        context: For the profiles.
    """

    def __init__(self, chosen: str, context: Context) -> None:
        names = _AUTO if chosen == "auto" else (chosen,)
        self._profiles = [PROFILES[name](context) for name in names]
        self._known: dict[str, Profile] = {}  # by address, where that alone decides

    def receive(self, message: Message) -> Items | None:
        """Return the poses that a message completes, None if it fits no profile.

        Raises:
            FrameError: If it is malformed.
        """
        profile = self.find(message)
        return None if profile is None else profile.receive(message)

    def idle(self, now: float) -> Items:
        """Return the frames that nothing more has come for."""
        return [item for profile in self._profiles for item in profile.idle(now)]

    def pending(self) -> bool:
        """Return whether a frame is open or held back."""
        return any(profile.pending() for profile in self._profiles)

    def find(self, message: Message) -> Profile | None:
        """Return the profile for a message, or None if it fits none."""
        known = self._known.get(message.address)
        if known is not None:
            return known
        for profile in self._profiles:
            if profile.claims(message):
                brief = len(message.address) <= _LONGEST and len(self._known) < _MAX_ADDRESSES
                if brief and profile.claims(message._replace(arguments=())):  # the address alone decides
                    self._known[message.address] = profile
                return profile
        return None
