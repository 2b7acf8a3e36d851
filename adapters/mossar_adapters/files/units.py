"""One unit of a file in metres."""

from collections.abc import Mapping

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import METRES, ReadOptions

USUAL_HEIGHT = 1.7  # m
ACCLAIM_INCH = 0.0254 / 0.45  # m, the unit of the CMU recordings
_NAMED = {
    name: metres
    for metres, names in (
        (1.0, "m meter meters metre metres"),
        (0.1, "dm decimeter decimeters decimetre decimetres"),
        (0.01, "cm centimeter centimeters centimetre centimetres"),
        (1e-3, "mm millimeter millimeters millimetre millimetres"),
        (0.0254, "in inch inches"),
        (0.3048, "ft foot feet"),
    )
    for name in names.split()
}


class Scale(msgspec.Struct, frozen=True):
    """The factor of a file's coordinates.

    Args:
        metres: Metres per unit of the file.
        note: For the user, if the unit was not stated.
    """

    metres: float
    note: str | None = None


def metres_of(unit: str) -> float | None:
    """Return a unit in metres by its name in files, None if it is not known.

    Example:
        >>> metres_of("Millimeters")
        0.001
    """
    return _NAMED.get(unit.strip(" []()").lower())


def height(positions: NDArray[np.floating]) -> float:
    """Return the height of a skeleton: its largest extent along an axis, median over the frames.

    People in T-pose span their own height, so that the vertical axis need not be known. Frames with
    fewer than half of the joints do not count.

    Args:
        positions: (n, J, 3), any unit, NaN where a joint is missing.

    Returns:
        The height in the same unit; 0 if there is no usable frame.
    """
    present = np.isfinite(positions).all(axis=2)  # (n, J)
    usable = present.sum(axis=1) * 2 >= max(2, positions.shape[1])
    if not usable.any():
        return 0.0
    kept = present[usable][:, :, None]
    low = np.where(kept, positions[usable], np.inf).min(axis=1)
    high = np.where(kept, positions[usable], -np.inf).max(axis=1)
    tallest: float = np.median((high - low).max(axis=1)).item()
    return tallest


def stated_scale(options: ReadOptions, stated: float) -> Scale:
    """Return the scale of a format that states its unit; the user's option takes precedence over the file."""
    return Scale(METRES.get(options.unit, stated))


def guessed_scale(options: ReadOptions, tall: float, candidates: Mapping[str, float] = METRES) -> Scale:
    """Return the scale of a format that does not state its unit.

    Args:
        options: The user's word, taken if there is one.
        tall: Height of the skeleton in the file's unit, 0 if it cannot be measured.
        candidates: Names of units and their metres.
    """
    if options.unit != "auto":
        return Scale(METRES[options.unit])
    if tall <= 0:
        return Scale(1.0, "unit taken as m (the height cannot be measured); set --unit to change")
    unit = min(candidates, key=lambda name: abs(np.log(tall * candidates[name] / USUAL_HEIGHT)))
    metres = candidates[unit]
    return Scale(
        metres, f"unit taken as {unit} (skeleton is {tall * metres:.2f} m tall); set --unit to change"
    )


def fitted_scale(options: ReadOptions, tall: float) -> Scale:
    """Return the scale of coordinates that have no unit: the skeleton becomes 1.7 m tall."""
    if options.unit != "auto":
        return Scale(METRES[options.unit])
    if tall <= 0:
        return Scale(1.0, "coordinates have no unit and the height cannot be measured; taken as metres")
    return Scale(
        USUAL_HEIGHT / tall,
        f"coordinates have no unit: scaled so that the skeleton is {USUAL_HEIGHT} m tall; set --unit to change",
    )
