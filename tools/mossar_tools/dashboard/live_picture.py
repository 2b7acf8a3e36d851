"""Live picture: the seconds of a stream that the page shows, drawn as `mossar segment --plot` draws a recording."""

import io
from collections.abc import Mapping

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.loaded import LoadedRecording
from mossar_tools.dashboard.glimpse import Glimpse
from mossar_tools.excerpt import Excerpt
from mossar_tools.marks import Mark
from mossar_tools.palette import Palette
from mossar_tools.plot import draw_excerpt
from mossar_tools.wording import strongest


def live_picture(
    glimpse: Glimpse,
    poses: Mapping[str, NDArray[np.float32]],
    level: tuple[float, str],
    palette: Palette,
) -> bytes:
    """Return the view of a performer as a PNG.

    Args:
        glimpse: The performer now.
        poses: (J, 3) m, at the key frames whose pose is known, by the id of the key frame.
        level: Strength from which key frames stand, and its name.
        palette: Colours.
    """
    marks = [mark for mark in glimpse.marks if not mark.tentative]
    missing = np.full((len(glimpse.skeleton), 3), np.nan, np.float32)
    known = np.array([poses.get(mark.id, missing) for mark in marks] or [missing])
    times = np.array([mark.time for mark in marks] or [glimpse.end])
    whole = LoadedRecording(f"live, {glimpse.performer}", glimpse.skeleton, None, known, times)
    target = io.BytesIO()
    draw_excerpt(target, whole, excerpt_of(glimpse, marks, level), palette)
    return target.getvalue()


def excerpt_of(glimpse: Glimpse, marks: list[Mark], level: tuple[float, str]) -> Excerpt:
    """Return the drawn excerpt; key frames are numbered in the order of their times, as their poses are.

    Args:
        glimpse: The performer now.
        marks: Key frames to draw, in order of time.
        level: Strength from which they stand, and its name.
    """
    numbered = [
        msgspec.structs.replace(mark, frame=i, strength=level[0] if mark.strength is None else mark.strength)
        for i, mark in enumerate(marks)
    ]
    known = [numbered[i] for i, mark in enumerate(marks) if mark.strength is not None]
    start, end = glimpse.start, max(glimpse.end, glimpse.start + 1e-3)
    return Excerpt(
        start=start,
        end=end,
        threshold=glimpse.threshold,
        curve=glimpse.curve,
        marks=numbered,
        stretches=glimpse.stretches,
        cuts=[],
        hierarchy=sorted(known, key=lambda mark: mark.strength or 0.0),
        whole=(start, end),
        level=level[0],
        level_name=f"{level[1]}\n{level[0]:.2f}",
        about=f"the last {end - start:.0f} s, {len(glimpse.skeleton)} joints; "
        f"{strongest(sum(mark.kept for mark in marks), len(marks))}",
    )
