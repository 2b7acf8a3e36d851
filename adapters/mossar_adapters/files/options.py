"""The options of a recording."""

import msgspec

from mossar_stream import SettingsError

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
MIN_FPS, MAX_FPS = 0.001, 100_000.0  # Hz


class ReadOptions(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Options of reading; the defaults trust the file.

    Args:
        fps: Rate in Hz; replaces the rate and the times in the file.
        unit: `m`, `cm`, `mm`, `inch`: the unit of the file; `auto` uses that of the format, or guesses it from the
            height of the skeleton.
        skeleton: Path of the skeleton file that belongs to the recording (`.asf` for `.amc`).
        root: Name of the joint that is the body centre.
        joints: Names of the joints to keep, in this order; empty keeps all.
        performer: Name of the only performer to read.
        allow_2d: Whether to take flat poses (z = 0) instead of refusing them.
        again: Whether to estimate a video again, although the estimate is kept beside it.

    Raises:
        SettingsError: If `fps` or `unit` is impossible.
    """

    fps: float | None = None
    unit: str = "auto"
    skeleton: str | None = None
    root: str | None = None
    joints: tuple[str, ...] = ()
    performer: str | None = None
    allow_2d: bool = False
    again: bool = False

    def __post_init__(self) -> None:
        if self.fps is not None and not plausible_rate(self.fps):
            raise SettingsError(f"fps must be {MIN_FPS} to {MAX_FPS:.0f} Hz, not {self.fps}")
        if self.unit != "auto" and self.unit not in METRES:
            raise SettingsError(f"unit must be auto, {', '.join(METRES)}, not {self.unit!r}")


def plausible_rate(fps: float) -> bool:
    """Return whether `fps` can be the rate of a recording."""
    return MIN_FPS <= fps <= MAX_FPS
