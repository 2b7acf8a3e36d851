"""The velocity of level `motion` and the sensor's noise on whole arrays, in plain Python; see `reference/motion.py`."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core import kernels
from mossar_stream.core.kernels import TIME_ROUNDING

WINDOW, SIG_THRESHOLD, RANGE_FLOOR, MARGIN = 0.1, 0.05, 0.01, 1.5  # s; share; m; setting noise_margin
Array = NDArray[np.float64]


class Heard(NamedTuple):
    """The velocity of a recording and its noise, at each frame.

    Args:
        velocity: m, rms over the joints.
        range: m, so far.
        noise: m/s, the speed that the sensor's noise adds to u.
        loud: Whether the velocity is that of filtered poses.
    """

    velocity: Array
    range: Array
    noise: Array
    loud: NDArray[np.bool_]


def velocity(poses: Array, times: Array, joints: int, speed: Array) -> Heard:
    """Return the velocity of poses, given the speed of the filtered ones, m/s."""
    moved = np.diff(poses, axis=0, prepend=poses[:1])
    steps = np.sqrt((moved**2).sum(axis=(1, 2)) / joints)
    n = len(poses)
    found = Heard(np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n, bool))
    ear, largest = _Ear(), 0.0
    for t, time in enumerate(times):
        line = SIG_THRESHOLD * max(largest, RANGE_FLOOR)
        if steps[t] > 0.0:
            ear.listen(moved[t], steps[t], time - times[t - 1])
        first = np.searchsorted(times, time - (WINDOW - 1e-6), side="right")
        found.velocity[t] = steps[first : t + 1].sum()
        found.noise[t] = ear.of_speed
        found.loud[t] = ear.level * WINDOW * MARGIN > line
        floor = RANGE_FLOOR
        if found.loud[t]:
            found.velocity[t] = speed[t] * WINDOW
            above = 1.0 + kernels.DEVIATIONS / np.sqrt(6.0 * joints)
            least = above * ear.of_speed * WINDOW / SIG_THRESHOLD
            floor = max(floor, min(least, kernels.MOST_RAISED * max(largest, RANGE_FLOOR)))
        largest = max(largest, found.velocity[t])
        found.range[t] = max(largest, floor)
    return found


class _Ear:
    """The estimated noise of the sensor; every frame comes in time."""

    def __init__(self) -> None:
        self.span = self.path = self.turn = self.heard = self.squares = 0.0
        self.estimate = self.step = 0.0  # m/s; s
        self.quietest = np.inf  # m/s
        self.known = False
        self.last: Array | float = 0.0

    def listen(self, moved: Array, path: float, dt: float) -> None:
        """Process the displacements of a frame."""
        self.step = dt
        squares = float((moved**2).sum())
        scale = np.sqrt(squares * self.squares)
        turned = float((moved * self.last).sum()) / scale if scale > 0.0 else 0.0
        self.last, self.squares = moved, squares
        keep = kernels.MEMORY / (kernels.MEMORY + dt)
        self.span, self.path = keep * (self.span + dt), keep * (self.path + path)
        self.turn = keep * (self.turn + turned * dt)
        self.heard += dt
        if self.span > kernels.BEGINNING + TIME_ROUNDING:
            self.quietest = min(self.quietest * 2.0 ** (dt / kernels.DOUBLING), self.path / self.span)
        turning = self.turn < kernels.TURNED_BACK * self.span
        self.known = self.known or turning
        if turning or (not self.known and self.heard < kernels.BEGINNING - TIME_ROUNDING):
            self.estimate = self.path / self.span * (1.0 + kernels.DOUBT * dt / self.span)
        elif not self.known:
            self.estimate = 0.0

    @property
    def level(self) -> float:
        """Path of the noise, m/s."""
        return min(self.estimate, self.quietest)

    @property
    def of_speed(self) -> float:
        """Speed that the noise adds to the filtered poses, m/s."""
        share = self.step / (self.step + kernels.SMOOTHING)
        return float(self.level * self.step * np.sqrt(share / (2.0 - share)) / kernels.SPEED_WINDOW)
