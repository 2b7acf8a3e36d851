"""Script: a move written down as strokes, seen from where the performer stands."""

import math

import msgspec

from mossar_adapters.demo.body import CHANNEL, CHANNELS, NEUTRAL, Floats, pose
from mossar_adapters.demo.strokes import Law, Stroke, minimum_jerk, there_and_back

_PLACES = tuple((CHANNEL[f"{part}_x"], CHANNEL[f"{part}_z"]) for part in ("hips", "l", "r"))


class Stance(msgspec.Struct, frozen=True):
    """Place and posture of the performer at ease.

    Args:
        x: Metres, the point of the floor below the hips.
        z: Metres.
        heading: Radians, 0 faces +z, positive is to the performer's left.
    """

    x: float = 0.0
    z: float = 0.0
    heading: float = 0.0

    def after(self, *, forward: float = 0.0, turned: float = 0.0) -> "Stance":
        """Return the stance `forward` metres ahead, then turned by radians to the left."""
        x = self.x + forward * math.sin(self.heading)
        z = self.z + forward * math.cos(self.heading)
        return Stance(x, z, self.heading + turned)

    def at_ease(self) -> Floats:
        """Return the pose (C,) of standing here, in the room's axes."""
        values = pose(NEUTRAL)
        values[[CHANNEL["hips_yaw"], CHANNEL["l_yaw"], CHANNEL["r_yaw"]]] += self.heading
        values = self.in_room(values)
        for x, z in _PLACES:
            values[[x, z]] += (self.x, self.z)
        return values

    def in_room(self, amount: Floats) -> Floats:
        """Return a difference of poses (C,), seen from here, in the room's axes."""
        turned = amount.copy()
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        for x, z in _PLACES:
            turned[x] = amount[x] * cos + amount[z] * sin
            turned[z] = amount[z] * cos - amount[x] * sin
        return turned


class Script:
    """Collects the strokes of one move, which starts from and ends in its posture.

    Args:
        stance: Place at which the move starts; x, z and yaw in its strokes are seen from there.
        start: Seconds from the start of the performance.
        pace: Factor on all times of the move.
        posture: (C,) the posture of the move, seen from the stance.
    """

    def __init__(self, stance: Stance, start: float, pace: float, posture: Floats) -> None:
        self.stance = stance
        self.start = start
        self.pace = pace
        self.strokes: list[Stroke] = []
        self.posture = dict(zip(CHANNELS, posture.tolist(), strict=True))  # metres and radians by channel
        self.goal = posture.copy()  # (C,) where the strokes so far lead to, seen from the stance

    @property
    def end(self) -> float:
        """Seconds from the start of the performance to the end of the last stroke."""
        return max((stroke.end for stroke in self.strokes), default=self.start)

    def to(self, at: float, until: float, law: Law = minimum_jerk, /, **targets: float) -> None:
        """Lead channels to target values.

        Args:
            at: Seconds from the start of the move.
            until: Seconds from the start of the move.
            law: Time law, from 0 to 1.
            targets: Metres and radians by channel.
        """
        amount = pose({name: value - self.goal[CHANNEL[name]] for name, value in targets.items()})
        self.goal += amount
        self._stroke(at, until, law, amount, lasting=True)

    def sway(self, at: float, until: float, law: Law = there_and_back, /, **amounts: float) -> None:
        """Move channels by amounts and back.

        Args:
            at: Seconds from the start of the move.
            until: Seconds from the start of the move.
            law: Time law that ends at 0.
            amounts: Metres and radians by channel.
        """
        self._stroke(at, until, law, pose(amounts), lasting=False)

    def back(self, at: float, until: float) -> None:
        """Lead every channel back to the posture where the move began."""
        self.to(at, until, **self.posture)

    def _stroke(self, at: float, until: float, law: Law, amount: Floats, *, lasting: bool) -> None:
        start, duration = self.start + at * self.pace, (until - at) * self.pace
        self.strokes.append(Stroke(start, duration, law, self.stance.in_room(amount), lasting))
