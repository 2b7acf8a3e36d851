"""The velocity of level `motion` and the sensor's noise on whole arrays, in plain Python; see `reference_motion.py`."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm import facts, noise

WINDOW, SIG_THRESHOLD, RANGE_FLOOR, MARGIN = 0.1, 0.05, 0.01, 1.5  # s; share; m; setting noise_margin
Array = NDArray[np.float64]


def velocity(poses: Array, times: Array, joints: int) -> tuple[Array, Array, Array]:
    """Return the velocity (m, rms over the joints), its range so far, and what noise adds to the speed u (m/s)."""
    moved = np.diff(poses, axis=0, prepend=poses[:1])
    curve, ranges, noises = np.zeros(len(poses)), np.zeros(len(poses)), np.zeros(len(poses))
    steps = np.zeros(len(poses))
    ear, largest = _Ear(), 0.0
    for t, time in enumerate(times):
        steps[t] = np.sqrt((moved[t] ** 2).sum() / joints)
        if t > 0:
            line = SIG_THRESHOLD * max(largest, RANGE_FLOOR)
            steps[t] = ear.calm(moved[t], steps[t], time - times[t - 1], line)
        first = np.searchsorted(times, time - (WINDOW - 1e-6), side="right")
        curve[t] = steps[first : t + 1].sum()
        largest = max(largest, curve[t])
        ranges[t] = max(largest, RANGE_FLOOR)
        noises[t] = ear.of_speed
    return curve, ranges, noises


class _Ear:
    """The sensor's noise, as far as it was heard; every frame comes in time."""

    def __init__(self) -> None:
        self.span = self.path = self.turn = self.heard = self.squares = 0.0
        self.estimate = self.step = 0.0  # m/s; s
        self.known = False
        self.last: Array | float = 0.0
        self.smooth: Array | None = None

    def calm(self, moved: Array, path: float, dt: float, line: float) -> float:
        """Take the displacements of a frame in, and return its path with loud noise smoothed out of it."""
        self.step = dt
        if path > 0.0:
            self._listen(moved, path, dt)
        loudness = self.estimate * WINDOW * MARGIN
        if not (loudness > line and self.turn < noise.TURNED * self.span):
            self.smooth = None
            return path
        k = (line / loudness) ** 2
        least = dt / (dt + noise.SLOWEST_OF_EVIDENCE)
        share = max(least, 0.5 * (np.sqrt(k * k + 8.0 * k) - k))
        self.smooth = share * self.last + (0.0 if self.smooth is None else (1.0 - share) * self.smooth)
        raw, left = (np.linalg.norm(vectors, axis=1).sum() for vectors in (moved, self.smooth))
        return float(left * path / raw) if raw > 0.0 else 0.0

    def _listen(self, moved: Array, path: float, dt: float) -> None:
        squares = float((moved**2).sum())
        scale = np.sqrt(squares * self.squares)
        turned = float((moved * self.last).sum()) / scale if scale > 0.0 else 0.0
        self.last, self.squares = moved, squares
        keep = noise.MEMORY / (noise.MEMORY + dt)
        self.span, self.path = keep * (self.span + dt), keep * (self.path + path)
        self.turn = keep * (self.turn + turned * dt)
        self.heard += dt
        turning = self.turn < noise.TURNED * self.span
        self.known = self.known or turning
        if turning or (not self.known and self.heard < noise.BEGINNING):
            self.estimate = self.path / self.span * (1.0 + noise.DOUBT * dt / self.span)
        elif not self.known:
            self.estimate = 0.0

    @property
    def of_speed(self) -> float:
        """What the noise adds to the speed u, m/s."""
        share = self.step / (self.step + facts.SMOOTHING)
        return float(self.estimate * self.step * np.sqrt(share / (2.0 - share)) / facts.SPEED_WINDOW)
