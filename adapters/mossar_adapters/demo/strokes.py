"""Strokes: the min-jerk pieces that a motion is made of.

A channel follows the sum of its strokes: each adds its amount times a time law that runs from 0 over the
stroke's duration. Point-to-point movements of people follow the minimum-jerk law (Flash and Hogan 1985), and
movements that run into each other are well described by overlapping strokes that add up (Flash and Henis
1991).
"""

from collections.abc import Callable
from typing import Final

import msgspec
import numpy as np

from mossar_adapters.demo.body import Floats

Law = Callable[[Floats], Floats]  # share of the stroke's duration, 0..1 -> share of its amount

GRAVITY: Final = 9.81

_CONTACT: Final = 0.34  # s on the floor between two jumps


class Stroke(msgspec.Struct, frozen=True):
    """One piece of motion.

    Args:
        start: Seconds from the start of the performance.
        duration: Seconds.
        law: Course of the share of `amount` over the duration.
        amount: (C,) gain of the channels, metres and radians.
        lasting: Whether the channels keep the amount afterwards; else the law ends at 0.
    """

    start: float
    duration: float
    law: Law
    amount: Floats
    lasting: bool

    @property
    def end(self) -> float:
        """Seconds from the start of the performance."""
        return self.start + self.duration

    def at(self, times: Floats) -> Floats:
        """Return the contribution of the stroke at `times` (n,), s: (n, C)."""
        share = self.law(np.clip((times - self.start) / self.duration, 0.0, 1.0))
        return share[:, None] * self.amount


def minimum_jerk(x: Floats) -> Floats:
    """Return 10x³ - 15x⁴ + 6x⁵: from rest to rest with the least jerk."""
    return x * x * x * (10.0 + x * (6.0 * x - 15.0))


def there_and_back(x: Floats) -> Floats:
    """Return a smooth bump of height 1 that starts and ends at rest."""
    return (4.0 * x * (1.0 - x)) ** 3


def ballistic(x: Floats) -> Floats:
    """Return the parabola of height 1 of a body in free flight."""
    return 4.0 * x * (1.0 - x)


def cruise(rise: float, fall: float) -> Law:
    """Return a law that gathers speed over the share `rise`, keeps it, and brakes over the share `fall`."""

    def ramp(x: Floats, share: float) -> Floats:
        y = np.clip(x / share, 0.0, 1.0)
        return share * y**4 * (2.5 + y * (y - 3.0))  # the integral of a minimum-jerk rise of speed

    def law(x: Floats) -> Floats:
        steady = np.clip(x, rise, 1.0 - fall) - rise
        return (ramp(x, rise) + steady + fall / 2 - ramp(1.0 - x, fall)) / (1.0 - rise / 2 - fall / 2)

    return law


def shaking(cycles: int) -> Law:
    """Return a law that swings to and fro `cycles` times, growing and fading over the first and last half."""

    def law(x: Floats) -> Floats:
        grown = minimum_jerk(np.clip(2.0 * cycles * np.minimum(x, 1.0 - x), 0.0, 1.0))
        return grown * np.sin(2.0 * np.pi * cycles * x)

    return law


class Hops(msgspec.Struct, frozen=True):
    """The height of the hips over jumps on the spot, metres above the posture: a law that is not normalised.

    Crouch, push, flights, contacts between them, landing and straightening up join with equal speed and
    acceleration: quintics (the minimum-jerk paths between such ends), and parabolas for the flights.

    Args:
        speed: Upward speed at take-off, m/s.
        count: How many jumps.
    """

    speed: float
    count: int

    @property
    def pieces(self) -> tuple[tuple[float, tuple[float, float, float], tuple[float, float, float]], ...]:
        """Duration (s) and (height, speed, acceleration) at both ends of the pieces."""
        ease, low = (0.0, 0.0, 0.0), (-0.13, 0.0, 8.0)
        off, on = (0.05, self.speed, -GRAVITY), (0.05, -self.speed, -GRAVITY)
        flight = (self.flight, off, on)
        between = ((_CONTACT, on, off), flight) * (self.count - 1)
        start = ((0.24, ease, low), (_CONTACT / 2, low, off), flight)
        return (*start, *between, (_CONTACT / 2, on, low), (0.36, low, ease))

    @property
    def flight(self) -> float:
        """Seconds in the air."""
        return 2.0 * self.speed / GRAVITY

    @property
    def period(self) -> float:
        """Seconds from take-off to take-off."""
        return self.flight + _CONTACT

    @property
    def rise(self) -> float:
        """Metres from take-off to the top."""
        return self.speed**2 / (2.0 * GRAVITY)

    @property
    def take_off(self) -> float:
        """Seconds from the start to the moment the toes leave the floor first."""
        return self.pieces[0][0] + self.pieces[1][0]

    @property
    def duration(self) -> float:
        """Seconds from the start of the crouch to being back in the posture."""
        return sum(piece[0] for piece in self.pieces)

    def __call__(self, x: Floats) -> Floats:
        """Return the heights (m) at shares `x` of the duration."""
        pieces = self.pieces
        seconds = x * self.duration
        begins = np.concatenate([[0.0], np.cumsum([piece[0] for piece in pieces])[:-1]])
        conditions = [seconds >= begin for begin in begins[::-1]]
        heights = [
            _quintic(seconds - begin, *piece) for begin, piece in zip(begins[::-1], pieces[::-1], strict=True)
        ]
        return np.select(conditions, heights)


def _quintic(
    seconds: Floats, duration: float, start: tuple[float, float, float], end: tuple[float, float, float]
) -> Floats:
    """Return the quintic between two (position, speed, acceleration) states."""
    (p0, v0, a0), (p1, v1, a1) = start, end
    d, x = duration, seconds / duration
    rest = p1 - p0 - v0 * d - a0 * d * d / 2
    speed = (v1 - v0 - a0 * d) * d
    bend = (a1 - a0) * d * d
    c3 = 10 * rest - 4 * speed + bend / 2
    c4 = -15 * rest + 7 * speed - bend
    c5 = 6 * rest - 3 * speed + bend / 2
    return p0 + x * (v0 * d + x * (a0 * d * d / 2 + x * (c3 + x * (c4 + x * c5))))
