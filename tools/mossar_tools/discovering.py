"""Discovering: the unlabelled moves of a recording, grouped into a few kinds.

The moving segments of the recording are taken as examples; those that show the same move make a kind.
"""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import Moves, MovesError, Settings, segment_recording
from mossar_tools.console import progress_of
from mossar_tools.figures import save, style
from mossar_tools.palette import Palette
from mossar_tools.poses import draw_body
from mossar_tools.stick_figures import project, view_of

POSES = 6  # of a kind in the picture
MOST_DRAWN = 20  # kinds
_WIDE, _TALL = 1.1, 1.5  # inches of a pose


class Part(msgspec.Struct, frozen=True):
    """A movement of a recording.

    Args:
        start: s, on its clock.
        end: s.
        positions: (n, J, 3) m.
        fps: Hz.
    """

    start: float
    end: float
    positions: NDArray[np.float32]
    fps: float


Kind = list[Part]


def discover(whole: LoadedRecording, settings: Settings) -> tuple[list[Kind], int]:
    """Return the kinds of moves in a recording, the most frequent first, and the number of omitted movements.

    In each kind the most typical movement comes first. Movements are left out if they are too
    short or too small for an example, if a joint is missing, or if there are too many to compare.

    Args:
        whole: The recording.
        settings: Of the segmentation; its level sets the length of moves.
    """
    result = segment_recording(
        whole.positions,
        whole.fps,
        whole.skeleton,
        settings,
        times=whole.times,
        on_progress=progress_of(f"segmenting {whole.name}"),
    )
    held = whole.held()
    candidates, parts, left_out = Moves(whole.skeleton), [], 0
    for segment in result.segments:
        if segment.state != "moving":
            continue
        positions, fps = held.between(segment.start_time, segment.end_time)
        part = Part(segment.start_time, segment.end_time, positions, fps or 1.0)
        try:
            candidates.add("movement", part.positions, part.fps)
        except MovesError:
            left_out += 1
            continue
        parts.append(part)
    return [[parts[place] for place in kind] for kind in candidates.kinds()], left_out


def lines_of(kinds: list[Kind]) -> list[str]:
    """Return a line for each kind, with the number and the times of its movements."""
    found = []
    for number, kind in enumerate(kinds, 1):
        moments = ", ".join(f"{part.start:.1f}" for part in sorted(kind, key=lambda part: part.start)[:8])
        more = ", ..." if len(kind) > 8 else ""
        found.append(f"kind {number:<4}{_often(kind):>9}, at {moments}{more} s")
    return found


def _often(kind: Kind) -> str:
    return "once" if len(kind) == 1 else f"{len(kind)} times"


def draw_kinds(path: Path, whole: LoadedRecording, kinds: list[Kind], palette: Palette) -> None:
    """Draw the most typical movement of each kind as a row of poses.

    Args:
        path: `.png`, `.svg` or `.pdf`.
        whole: The recording.
        kinds: See `discover`.
        palette: Colours.

    Raises:
        MossarError: If the file cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    shown = kinds[:MOST_DRAWN]
    view = view_of(whole.skeleton, whole.positions[:: max(1, len(whole.positions) // 200)].astype(np.float64))
    with mpl.rc_context(style(palette)):
        rows = max(1, len(shown))
        figure = Figure(figsize=(_WIDE * (POSES + 1), _TALL * rows))
        for number, kind in enumerate(shown):
            bottom = 1 - (number + 1) / rows
            figure.text(0.01, bottom + 0.5 / rows, f"kind {number + 1}\n{_often(kind)}", va="center")
            for place in range(POSES):
                box = ((place + 1) / (POSES + 1), bottom + 0.06 / rows, 1 / (POSES + 1), 0.88 / rows)
                frame = round(place * (len(kind[0].positions) - 1) / (POSES - 1))
                _draw_pose(figure.add_axes(box), whole, kind[0].positions[frame], view, palette)
        save(figure, path)


def _draw_pose(
    axes: Any, whole: LoadedRecording, pose: NDArray[np.float32], view: Any, palette: Palette
) -> None:
    flat = project(pose.astype(np.float64), view)
    flat[:, 1] -= np.nanmin(flat[:, 1])
    axes.set_axis_off()
    axes.set_xlim(-0.6 * view.height, 0.6 * view.height)
    axes.set_ylim(-0.1 * view.height, 1.3 * view.height)
    axes.set_aspect("equal")
    draw_body(axes, whole.skeleton, flat[:, 0], flat[:, 1], palette)
