"""Reading: recordings from outside, in one call.

The readers of formats are `mossar_adapters.files`, which this package does not import before they are needed.
"""

from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from mossar_stream.frames import Frames
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton

_FILES = "mossar_adapters.files"


class Recorded(Protocol):
    """A recording in memory, such as `read` returns."""

    @property
    def positions(self) -> NDArray[Any]:
        """Positions, (n, J, 3) m; NaN where a joint is missing."""

    @property
    def times(self) -> NDArray[np.float64]:
        """Times of the frames, (n,) s."""

    @property
    def fps(self) -> float | None:
        """Nominal rate, Hz, if it is known."""

    @property
    def skeleton(self) -> Skeleton:
        """The joints."""

    @property
    def up(self) -> Up:
        """The axis that points upwards."""


class Opened(Protocol):
    """A recording on disk that was opened, such as `mossar_adapters.files.open_recording` returns."""

    @property
    def skeleton(self) -> Skeleton:
        """The joints."""

    @property
    def chunks(self) -> Callable[[], Iterable[Frames]]:
        """One pass over the frames."""


def read(path: str | Path, **options: Any) -> Any:
    """Read a recording of any format: BVH, C3D, TRC, AMC, CSV, npz, videos and more.

    Args:
        path: Path of the file.
        options: Fields of `mossar_adapters.files.ReadOptions`, as unit="cm" or joints=("Hips", "Head").

    Returns:
        A `mossar_adapters.files.LoadedRecording`: `positions`, `times`, `fps`, `skeleton`, and `segment(level=...)`.

    Raises:
        MossarError: If it cannot be read; one line has the reason and the remedy.

    Example:
        >>> import mossar_stream
        >>> take = mossar_stream.read("walk.bvh")  # doctest: +SKIP
        >>> mossar_stream.segment_recording(take).key_frames  # doctest: +SKIP
    """
    return import_module(_FILES).read(path, **options)


def recorded(given: object) -> Recorded | None:
    """Return a recording in memory, whether it was read or opened; None for other objects."""
    if not hasattr(given, "skeleton"):
        return None
    return cast("Recorded", import_module(_FILES).load(given) if hasattr(given, "chunks") else given)
