"""A sensor between performer and receiver: noise, jitter, dropped frames."""

from typing import Final

import numpy as np

from mossar_adapters.demo.body import SKELETON, Floats
from mossar_adapters.demo.style import Style

# The kinect kind; shares are per frame. Its rates are ours, chosen by eye after depth-camera recordings.
_FAR_JOINTS: Final = tuple(
    i for i, name in enumerate(SKELETON.names) if name.endswith(("Hand", "Foot", "Toes"))
)
_FAR_FACTOR: Final = 2.0
_SPEED_DOUBLING: Final = 2.0  # m/s at which sigma has doubled
_REPEATED: Final = 0.02
_JUMPS: Final = 0.005
_JUMP_SIZE: Final = 0.15  # m, standard deviation per axis
_DROPOUTS: Final = 0.004
_LONGEST_DROPOUT: Final = 6  # frames

_LEAST_STEP: Final = 1e-6  # s between two time stamps


class Sensor:
    """Turns true joint positions into received ones; has its own random numbers.

    White noise is Gaussian with standard deviation `noise` per axis. The `kinect` kind grows with a joint's
    speed, is doubled for hands and feet, and has repeated frames, single joints that jump, and hands or feet
    that are missing (NaN) for some frames.

    Args:
        seed: Of the random numbers.
        style: Rate, noise, jitter and losses; the time stamps stay in increasing order.
    """

    def __init__(self, seed: int, style: Style) -> None:
        self._rng = np.random.Generator(np.random.PCG64([seed, 1]))
        self._style = style
        self._true: Floats | None = None  # (J, 3) metres, the last true positions
        self._shown: Floats | None = None  # (J, 3) metres, the last positions passed on
        self._missing = np.zeros(len(SKELETON), np.int64)  # frames that each joint stays missing
        self._latest = 0.0  # s, the last time stamp

    def sense(self, positions: Floats, times: Floats) -> tuple[Floats, Floats]:
        """Return positions (m, J, 3) and times (m,) of the frames that arrive, of (n, J, 3) and (n,)."""
        if self._style.noise_kind == "kinect":
            positions = self._kinect(positions)
        elif self._style.noise > 0:
            positions = positions + self._rng.normal(0.0, self._style.noise, positions.shape)
        if self._style.jitter > 0:
            times = self._late(times)
        if self._style.drop > 0:
            arrives = self._rng.random(len(times)) >= self._style.drop
            positions, times = positions[arrives], times[arrives]
        return positions, times

    def _late(self, times: Floats) -> Floats:
        steps = _LEAST_STEP * np.arange(1, len(times) + 1)
        moved = np.maximum(times + self._rng.normal(0.0, self._style.jitter, len(times)), 0.0) - steps
        late: Floats = np.maximum(np.maximum.accumulate(moved), self._latest) + steps
        self._latest = float(late[-1])
        return late

    def _kinect(self, positions: Floats) -> Floats:
        before = positions[:1] if self._true is None else self._true[None]
        speed = np.sqrt(np.sum(np.diff(positions, axis=0, prepend=before) ** 2, axis=-1)) * self._style.fps
        self._true = positions[-1]
        sigma = self._style.noise * (1.0 + speed / _SPEED_DOUBLING)
        sigma[:, _FAR_JOINTS] *= _FAR_FACTOR
        seen: Floats = positions + sigma[:, :, None] * self._rng.normal(0.0, 1.0, positions.shape)
        for i, chances in enumerate(self._rng.random((len(seen), 3))):
            seen[i] = self._mishaps(seen[i], *chances)
        return seen

    def _mishaps(self, frame: Floats, repeated: float, jumps: float, dropout: float) -> Floats:
        """Return a frame (J, 3) with random errors, by three probabilities in 0..1."""
        if jumps < _JUMPS:
            frame[self._rng.integers(1, len(frame))] += self._rng.normal(0.0, _JUMP_SIZE, 3)
        if dropout < _DROPOUTS:
            self._missing[self._rng.choice(_FAR_JOINTS)] = self._rng.integers(2, _LONGEST_DROPOUT + 1)
        frame[self._missing > 0] = np.nan
        self._missing = np.maximum(self._missing - 1, 0)
        if repeated < _REPEATED and self._shown is not None:
            return self._shown
        self._shown = frame.copy()
        return frame
