"""Plot: a segmented recording as one picture.

From the top: the skeleton at the key frames that stand; the velocity curve between floor and ceiling, with key
frames by kind; the segments; the hierarchy as a tree, with the level that was chosen. If marks are too many to be
distinguished, the strongest are drawn and the last line counts the rest.
"""

import math
import textwrap
from pathlib import Path
from typing import Any, BinaryIO

from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import Result, Segmentation
from mossar_tools.excerpt import Excerpt, excerpt
from mossar_tools.figures import FONT, save, style
from mossar_tools.options import WIDTH
from mossar_tools.palette import Palette
from mossar_tools.panels import draw_curve, draw_segments, draw_strip, draw_tree
from mossar_tools.poses import draw_poses
from mossar_tools.stick_figures import sides
from mossar_tools.wording import strongest

# Inches.
_LEFT, _RIGHT = 0.73, 0.57  # margins
_POSES, _CURVE, _STRIP, _TREE = 1.41, 1.62, 0.23, 1.50  # heights of panels
_GAP = 0.13
_LINE = 0.23  # of the legend and the title
_AXIS = 0.46  # below the last panel
_NOTE = 0.17  # a line of the note


def draw(
    path: Path,
    whole: LoadedRecording,
    result: Result,
    chosen: Segmentation,
    palette: Palette,
    count: int | None = None,
    *,
    width: float = WIDTH,
) -> None:
    """Draw a picture into a file.

    Args:
        path: `.png`, `.svg` or `.pdf`.
        whole: The recording.
        result: Its result, with curves.
        chosen: The level to show.
        palette: Colours.
        count: Wanted number of key frames, if not a level.
        width: Inches.

    Raises:
        MossarError: If the file cannot be written.
    """
    draw_excerpt(path, whole, excerpt(whole, result, chosen, count=count), palette, width)


def draw_excerpt(
    target: Path | BinaryIO, whole: LoadedRecording, shown: Excerpt, palette: Palette, width: float = WIDTH
) -> None:
    """Draw the results between two times.

    Args:
        target: A path as for `draw`, or a binary file that takes a PNG.
        whole: The recording.
        shown: The excerpt.
        palette: Colours.
        width: Inches.

    Raises:
        MossarError: If the file cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(style(palette)):
        columns = max(2, int((width - _LEFT) / 0.9))
        rows = math.ceil(_legend_length(whole, shown) / columns)
        head = 0.32 + _LINE * (rows + (1 if width < 8 else 0)) + 0.1
        tall = [_POSES, _CURVE, _STRIP, *[_STRIP] * len(shown.limbs), _TREE]
        height = head + sum(tall) + (len(tall) - 1) * _GAP + _AXIS + _NOTE * math.ceil(200 / _letters(width))
        figure = Figure(figsize=(width, height))
        panels = _panels(figure, width, height, head, tall)
        inner = width - _LEFT - _RIGHT
        for panel in panels:
            panel.set_xlim(shown.start, shown.end)
        left_out = draw_poses(panels[0], whole, shown, (inner, _POSES), palette)
        left_out += draw_curve(panels[1], shown, inner, palette)
        left_out += draw_segments(panels[2], shown, inner, palette)
        for panel, (name, segments) in zip(panels[3:-1], shown.limbs.items(), strict=True):
            left_out += draw_strip(panel, name, segments, shown, inner, palette)
        left_out += draw_tree(panels[-1], shown, inner, palette)
        for panel in panels[:-1]:
            panel.tick_params(labelbottom=False, bottom=False)
        panels[-1].set_xlabel("time (s)")
        figure.align_ylabels([panels[1], panels[-1]])
        _draw_title(figure, whole, shown, palette)
        _draw_legend(figure, whole, shown, panels[1], columns, palette)
        _draw_note(
            figure, left_out, "" if shown.about else "; --from, --until and --width show more", palette
        )
        save(figure, target)


def _panels(figure: Any, width: float, height: float, head: float, heights: list[float]) -> list[Any]:
    panels, top = [], height - head
    for tall in heights:
        box = (_LEFT / width, (top - tall) / height, (width - _LEFT - _RIGHT) / width, tall / height)
        panels.append(figure.add_axes(box))
        top -= tall + _GAP
    return panels


def _draw_title(figure: Any, whole: LoadedRecording, shown: Excerpt, palette: Palette) -> None:
    width, height = figure.get_size_inches()
    name = Path(whole.name).name
    room = int((width - 1.3) * 9) if width < 8 else int((width - 6.2) * 9)
    figure.text(
        _LEFT / width,
        1 - 0.29 / height,
        textwrap.shorten(name, room, placeholder="…") if " " in name else _cut(name, room),
        fontsize=11,
        weight="bold",
    )
    summary = _summary(whole, shown)
    if width < 8:
        figure.text(
            _LEFT / width, 1 - (0.29 + _LINE) / height, summary, color=palette.muted, fontsize=FONT - 1
        )
    else:
        figure.text(1 - _RIGHT / width, 1 - 0.29 / height, summary, ha="right", color=palette.muted)


def _cut(text: str, room: int) -> str:
    return text if len(text) <= room else f"{text[: room - 1]}…"


def _summary(whole: LoadedRecording, shown: Excerpt) -> str:
    if shown.about is not None:
        return shown.about
    rate = f" at {whole.fps:g} Hz" if whole.fps else ""
    part = ""
    if (shown.start, shown.end) != shown.whole or whole.outside != (0, 0):
        part = f" from {shown.start:g} to {shown.end:g} s"
    return (
        f"{len(whole.times)} frames{rate}, {len(whole.skeleton)} joints; "
        f"{strongest(len(shown.kept), len(shown.marks))}{part}"
    )


def _legend_length(whole: LoadedRecording, shown: Excerpt) -> int:
    kinds = {key.kind for key in shown.marks}
    return 5 + len(kinds) + bool(shown.cuts) + 2 * bool(sides(whole.skeleton).any())


def _draw_legend(
    figure: Any, whole: LoadedRecording, shown: Excerpt, curve: Any, columns: int, palette: Palette
) -> None:
    """Draw one legend for all panels, below the title."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles, labels = curve.get_legend_handles_labels()
    extra: list[Any] = [
        Patch(color=palette.moving, label="moving"),
        Patch(color=palette.resting, label="resting"),
    ]
    if shown.cuts:
        extra.append(Line2D([], [], color=palette.truth, marker="|", ms=9, mew=1.8, ls="", label="true cut"))
    if sides(whole.skeleton).any():
        extra += [Line2D([], [], color=palette.left, lw=1.8, label="left side")]
        extra += [Line2D([], [], color=palette.right, lw=1.8, label="right side")]
    width, height = figure.get_size_inches()
    figure.legend(
        [*handles, *extra],
        [*labels, *(handle.get_label() for handle in extra)],
        loc="upper left",
        bbox_to_anchor=((_LEFT - 0.09) / width, 1 - (0.31 + (_LINE if width < 8 else 0)) / height),
        ncols=columns,
        handlelength=1.5,
        handletextpad=0.5,
        columnspacing=1.3,
        borderaxespad=0.2,
    )


def _letters(width: float) -> int:
    """Return the number of letters of the note that fit into a line."""
    return int((width - _LEFT - 0.2) * 17)


def _draw_note(figure: Any, left_out: list[str], advice: str, palette: Palette) -> None:
    """Write at the bottom which marks were left out."""
    if not left_out:
        return
    width, height = figure.get_size_inches()
    text = f"not drawn, for want of room: {'; '.join(left_out)}. The strongest are{advice}."
    lines = textwrap.wrap(text, _letters(width))
    figure.text(
        _LEFT / width, 0.06 / height, "\n".join(lines), color=palette.muted, fontsize=FONT - 1.5, va="bottom"
    )
