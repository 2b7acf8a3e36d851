"""Style: how a performer moves and is seen."""

from typing import Final

import msgspec

from mossar_stream import SettingsError

NOISE_KINDS: Final = ("white", "kinect")

_RANGES: Final = (("fps", 1, 1000), ("tempo", 0.2, 5), ("noise", 0, 1), ("jitter", 0, 0.1), ("drop", 0, 0.9))


class Style(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Rate and tempo of a performer, and the errors of the sensor.

    Args:
        fps: Hz, 1 to 1000.
        tempo: 0.2 to 5; 2 is twice as fast (a jump keeps the time of free fall).
        noise: Standard deviation of the sensor noise per axis, m, 0 to 1.
        noise_kind: `white` or `kinect`, see `Sensor`.
        jitter: Standard deviation of the time stamps, s, 0 to 0.1.
        drop: Share of frames that get lost, 0 to 0.9.

    Raises:
        SettingsError: If a value is out of its range.
    """

    fps: float = 60.0
    tempo: float = 1.0
    noise: float = 0.0
    noise_kind: str = "white"
    jitter: float = 0.0
    drop: float = 0.0

    def __post_init__(self) -> None:
        for name, low, high in _RANGES:
            if not low <= getattr(self, name) <= high:
                raise SettingsError(f"{name} must lie in {low:g} to {high:g}, not {getattr(self, name):g}")
        if self.noise_kind not in NOISE_KINDS:
            raise SettingsError(f"noise_kind must be {' or '.join(NOISE_KINDS)}, not {self.noise_kind!r}")
