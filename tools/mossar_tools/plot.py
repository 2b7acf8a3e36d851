"""Plot: a segmented recording as one picture.

From the top: the skeleton at the key frames that stand; the velocity curve between floor and ceiling, with all key
frames by kind; the segments; the hierarchy as a tree, with the level that was chosen.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mossar_stream.presets import bundle_name, level_strength
from mossar_stream.recording import Result, Segmentation
from mossar_tools.dendrogram import merges
from mossar_tools.figures import FONT, save, style
from mossar_tools.loaded_recording import LoadedRecording
from mossar_tools.palette import Palette
from mossar_tools.stick_figures import head_of, project, sides, view_of

WIDTH, HEIGHT = 11.0, 6.6  # inches
RATIOS = (1.75, 2.0, 0.26, 1.9)  # heights of the panels
LEFT, RIGHT = 0.066, 0.948
MOST_FIGURES = 15
MOST_POINTS = 6000  # of a curve; more would only make the file large

_MARKS = {"onset": "^", "offset": "v", "minimum": "o"}


def draw(
    path: Path,
    whole: LoadedRecording,
    result: Result,
    chosen: Segmentation,
    palette: Palette,
    kept: int | None = None,
) -> None:
    """Draw a picture into a file.

    Args:
        path: `.png`, `.svg` or `.pdf`.
        whole: The recording.
        result: What was found in it, with curves.
        chosen: The level to show.
        palette: Colours.
        kept: Number of key frames asked for, if it was not a level.

    Raises:
        MossarError: If the file cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(style(palette)):
        figure = Figure(figsize=(WIDTH, HEIGHT))
        grid = figure.add_gridspec(
            4, 1, height_ratios=RATIOS, left=LEFT, right=RIGHT, top=0.9, bottom=0.07, hspace=0.1
        )
        panels = [figure.add_subplot(grid[i]) for i in range(4)]
        start, end = (float(whole.times[0]), float(whole.times[-1])) if len(whole.times) else (0.0, 1.0)
        for panel in panels:
            panel.set_xlim(start, end if end > start else start + 1.0)
        _draw_figures(panels[0], whole, chosen, palette)
        _draw_curve(panels[1], result, chosen, palette)
        _draw_segments(panels[2], whole, chosen, palette)
        _draw_tree(panels[3], result, chosen, kept, (start, end), palette)
        for panel in panels[:3]:
            panel.tick_params(labelbottom=False, bottom=False)
        panels[3].set_xlabel("time (s)")
        figure.align_ylabels([panels[1], panels[3]])
        figure.text(LEFT, 0.957, Path(whole.name).name, fontsize=11, weight="bold")
        figure.text(RIGHT, 0.957, _facts(whole, result, chosen), ha="right", color=palette.muted)
        _draw_legend(figure, whole, panels[1], palette)
        save(figure, path)


def _facts(whole: LoadedRecording, result: Result, chosen: Segmentation) -> str:
    rate = f" at {whole.fps:g} Hz" if whole.fps else ""
    return (
        f"{len(whole.times)} frames{rate}, {len(whole.skeleton)} joints; "
        f"{len(chosen.key_frames)} of {len(result.key_frames)} key frames stand"
    )


def _draw_legend(figure: Any, whole: LoadedRecording, curve: Any, palette: Palette) -> None:
    """Draw one legend for all panels, below the title."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles, labels = curve.get_legend_handles_labels()
    extra: list[Any] = [
        Patch(color=palette.moving, label="moving"),
        Patch(color=palette.resting, label="resting"),
    ]
    if whole.cuts:
        extra.append(Line2D([], [], color=palette.truth, marker="|", ms=9, mew=1.8, ls="", label="true cut"))
    if sides(whole.skeleton).any():
        extra += [Line2D([], [], color=palette.left, lw=1.8, label="left side")]
        extra += [Line2D([], [], color=palette.right, lw=1.8, label="right side")]
    figure.legend(
        [*handles, *extra],
        [*labels, *(handle.get_label() for handle in extra)],
        loc="upper left",
        bbox_to_anchor=(LEFT - 0.008, 0.953),
        ncols=12,
        handlelength=1.5,
        handletextpad=0.5,
        columnspacing=1.3,
    )


def _draw_figures(axes: Any, whole: LoadedRecording, chosen: Segmentation, palette: Palette) -> None:
    """Draw the skeleton at the strongest key frames, side by side, tied to their times."""
    axes.set_axis_off()
    axes.set_ylim(-0.3, 1.1)
    keys = sorted(sorted(chosen.key_frames, key=lambda k: -k.strength)[:MOST_FIGURES], key=lambda k: k.time)
    if not keys:
        return
    left, right = axes.get_xlim()
    view = view_of(whole.skeleton, whole.positions[:: max(1, len(whole.positions) // 200)].astype(np.float64))
    places = spread([key.time for key in keys], left, right, (right - left) / (MOST_FIGURES + 1.0))
    # A metre must be as long across as upwards: from vertical units to seconds by way of the panel's shape.
    box = axes.get_position()
    shape = (box.height * HEIGHT / 1.4) / (box.width * WIDTH / (right - left))
    scale = 1.0 / view.height
    for key, place in zip(keys, places, strict=True):
        flat = project(whole.positions[key.frame].astype(np.float64), view)
        if not np.isfinite(flat).any():
            continue
        low = np.nanmin(flat[:, 1])
        x = place + flat[:, 0] * scale * shape
        y = (flat[:, 1] - low) * scale
        _draw_body(axes, whole, x, y, palette)
        axes.plot(
            [place, place, key.time, key.time],
            [-0.06, -0.11, -0.25, -0.37],
            color=palette.muted,
            lw=0.6,
            clip_on=False,
        )


def _draw_body(axes: Any, whole: LoadedRecording, x: Any, y: Any, palette: Palette) -> None:
    side = sides(whole.skeleton)
    colours = {1: palette.left, -1: palette.right, 0: palette.ink}
    for parent, child in whole.skeleton.bones():
        where = side[child] if side[child] == side[parent] or side[parent] == 0 else 0
        axes.plot(
            x[[parent, child]],
            y[[parent, child]],
            color=colours[where],
            lw=1.8,
            solid_capstyle="round",
            clip_on=False,
        )
    head = head_of(whole.skeleton)
    if head >= 0:
        axes.plot(x[head], y[head], "o", ms=5.5, color=palette.ink, clip_on=False)
    if not whole.skeleton.bones():
        axes.plot(x, y, "o", ms=2.0, color=palette.ink, clip_on=False)


def spread(times: Sequence[float], low: float, high: float, gap: float) -> list[float]:
    """Return places as near as can be to `times` that lie `gap` apart, in the same order, within low..high.

    Args:
        times: In ascending order.
        low: Where the space begins.
        high: Where it ends.
        gap: Between two places; there must be room for all of them.

    Example:
        >>> spread([5.0, 5.1], 0.0, 10.0, 1.0)
        [4.55, 5.55]
    """
    # Clusters of neighbours that touch are centred on the mean of their times, and joined while they overlap.
    clusters: list[list[float]] = []  # [sum of (time - rank * gap), count]
    for time in times:
        clusters.append([time, 1])
        while len(clusters) > 1:
            (sum_a, n_a), (sum_b, n_b) = clusters[-2:]
            if sum_a / n_a + n_a * gap <= sum_b / n_b:
                break
            clusters[-2:] = [[sum_a + sum_b - n_b * n_a * gap, n_a + n_b]]
    places = [total / n + rank * gap for total, n in clusters for rank in range(int(n))]
    for i in range(len(places)):
        places[i] = max(places[i], low + gap / 2 + i * gap)
    for i in range(len(places)):
        places[-1 - i] = min(places[-1 - i], high - gap / 2 - i * gap)
    return [round(place, 9) for place in places]


def _draw_curve(axes: Any, result: Result, chosen: Segmentation, palette: Palette) -> None:
    """Draw velocity, envelope and threshold, and all key frames by kind."""
    curves = result.curves
    step = max(1, len(curves) // MOST_POINTS)
    times = np.array([state.time for state in curves[::step]])
    value, ceiling, floor = (
        np.array([getattr(state, name) for state in curves[::step]], np.float64)
        for name in ("value", "ceiling", "floor")
    )
    top = max(0.2, float(np.nanmax(value, initial=0.0)) * 1.08)
    axes.set_ylim(0, top)
    axes.set_ylabel("velocity (share of range)")
    axes.fill_between(
        times,
        np.clip(floor, 0, top),
        np.clip(ceiling, 0, top),
        color=palette.faint,
        lw=0,
        label="floor to ceiling",
    )
    axes.plot(times, value, color=palette.ink, lw=0.9, label="velocity")
    if curves:
        axes.axhline(curves[0].threshold, color=palette.muted, lw=0.8, ls=(0, (4, 3)), label="threshold")
    colours = {"onset": palette.onset, "offset": palette.offset, "minimum": palette.minimum}
    for kind, mark in _MARKS.items():
        found = [key for key in result.key_frames if key.kind == kind]
        if found:
            axes.plot(
                [key.time for key in found],
                [key.velocity for key in found],
                mark,
                ms=4.5,
                mfc=palette.background,
                mec=colours[kind],
                mew=1.0,
                label=kind,
                clip_on=False,
                zorder=4,
            )
    shown = {state.frame: state.value for state in curves}
    for key in chosen.key_frames:
        axes.axvline(key.time, ymax=1.02, color=colours[key.kind], lw=0.9, zorder=1, clip_on=False)
        axes.plot(
            key.time,
            shown.get(key.frame, key.velocity),
            _MARKS[key.kind],
            ms=5,
            color=colours[key.kind],
            zorder=5,
        )


def _draw_segments(axes: Any, whole: LoadedRecording, chosen: Segmentation, palette: Palette) -> None:
    """Draw the segments coloured by state, and true cuts where they are known."""
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    for part in chosen.segments:
        axes.axvspan(
            part.start_time,
            part.end_time,
            ymin=0.08,
            ymax=0.92,
            facecolor=palette.moving if part.state == "moving" else palette.resting,
            edgecolor=palette.background,
            lw=1.6,
        )
    for cut in whole.cuts:
        axes.plot([cut.time, cut.time], [-0.15, 1.15], color=palette.truth, lw=1.6, clip_on=False, zorder=5)
    axes.text(-0.006, 0.5, "segments", transform=axes.transAxes, ha="right", va="center")


def _draw_tree(
    axes: Any,
    result: Result,
    chosen: Segmentation,
    kept: int | None,
    span: tuple[float, float],
    palette: Palette,
) -> None:
    """Draw the hierarchy; below the chosen level each segment in the colour of its state."""
    axes.set_yscale("function", functions=(_root, _square))
    axes.set_ylabel("strength")
    found = merges(result.hierarchy, *span)
    level, name = _level(result, chosen, kept)
    highest = max((merge.height for merge in found), default=1.0)
    axes.set_ylim(0, max(highest, level) * 1.15 + 1e-9)
    axes.set_yticks(ticks := _ticks(axes.get_ylim()[1]), [f"{tick:g}" for tick in ticks])
    for merge in found:
        colour = _state_colour((merge.start + merge.end) / 2, chosen, palette)
        beam = palette.muted if merge.height >= level else colour
        axes.plot(
            [merge.left, merge.right], [merge.height] * 2, color=beam, lw=1.2, solid_capstyle="projecting"
        )
        for place, foot in ((merge.left, merge.left_height), (merge.right, merge.right_height)):
            colour = _state_colour(place, chosen, palette)
            knee = min(max(level, foot), merge.height)
            axes.plot([place, place], [foot, knee], color=colour, lw=1.5, solid_capstyle="butt")
            axes.plot(
                [place, place], [knee, merge.height], color=palette.muted, lw=1.0, solid_capstyle="butt"
            )
    axes.axhline(level, color=palette.level, lw=1.1, ls=(0, (5, 2)))
    axes.text(
        1.005,
        level,
        name,
        color=palette.level,
        transform=axes.get_yaxis_transform(),
        va="center",
        fontsize=FONT - 1,
    )


def _level(result: Result, chosen: Segmentation, kept: int | None) -> tuple[float, str]:
    """Return the strength from which key frames stand, and what to call it."""
    settings = result.settings
    if kept is None:
        strength = level_strength(settings.level, settings.resolved(), bundle_name(settings))
        return (
            strength,
            f"level\n{strength:.2f}" if strength == settings.level else f"{settings.level}\n{strength:.2f}",
        )
    fallen = result.hierarchy[: len(result.hierarchy) - len(chosen.key_frames)]
    standing = result.hierarchy[len(fallen) :]
    low = fallen[-1].strength if fallen else 0.0
    high = standing[0].strength if standing else low * 1.2
    return (low + high) / 2, f"{len(standing)}\nkept"


def _state_colour(time: float, chosen: Segmentation, palette: Palette) -> str:
    for part in chosen.segments:
        if part.start_time <= time <= part.end_time:
            return palette.moving if part.state == "moving" else palette.resting
    return palette.muted


def _ticks(top: float) -> list[float]:
    usual: list[float] = [0, 0.1, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64]
    return [tick for tick in usual if tick <= top]


def _root(values: Any) -> Any:
    return np.sqrt(np.maximum(values, 0))


def _square(values: Any) -> Any:
    return np.square(values)
