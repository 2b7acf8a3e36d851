"""Angle curves: the angles of every frame as a table, or as a picture with the repetitions behind them."""

from pathlib import Path

import numpy as np

from mossar_adapters.files.loaded import LoadedRecording
from mossar_adapters.files.output import OutputError
from mossar_adapters.files.replacing import Draft
from mossar_adapters.table_text import csv_text
from mossar_stream import Result, joint_angles
from mossar_tools.errors import UsageError
from mossar_tools.palette import Palette

WIDTH, ROW = 11.0, 1.5  # inches
SPAN = 10.0  # degrees that an axis shows at least, so that the noise of a still joint does not fill it


def write_curves(path: Path, whole: LoadedRecording, result: Result, palette: Palette) -> None:
    """Write the angles of a recording.

    Args:
        path: `.csv`, or a picture.
        whole: The recording.
        result: Its repetitions stand behind the curves of a picture.
        palette: Colours.

    Raises:
        MossarError: If no joints are known, or the file cannot be written.
    """
    angles = joint_angles(whole.positions, whole.skeleton, whole.up)
    if not angles:
        raise UsageError(f"{whole.name}: no angles: its joints are not known by name")
    if path.suffix.lower() == ".csv":
        try:
            with Draft(path) as draft, draft.path.open("w", encoding="utf-8", newline="") as file:
                file.write(csv_text([["time", *angles]]))
                for time, *values in zip(whole.times, *angles.values(), strict=True):
                    cells = ["" if np.isnan(value) else f"{value:.2f}" for value in values]
                    file.write(csv_text([[f"{time:.4f}", *cells]]))
        except OSError as error:
            raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None
        return
    _draw(path, whole, result, angles, palette)


def _draw(
    path: Path, whole: LoadedRecording, result: Result, angles: dict[str, np.ndarray], palette: Palette
) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from mossar_tools.figures import save, style

    kinds = list(dict.fromkeys(name.removeprefix("left_").removeprefix("right_") for name in angles))
    with mpl.rc_context(style(palette)):
        figure = Figure(figsize=(WIDTH, ROW * len(kinds) + 0.5), layout="constrained")
        for axes, kind in zip(np.atleast_1d(figure.subplots(len(kinds), sharex=True)), kinds, strict=True):
            for name, colour in (
                (f"left_{kind}", palette.left),
                (f"right_{kind}", palette.right),
                (kind, palette.ink),
            ):
                if name in angles:
                    side = name.removesuffix(kind).strip("_") or kind.split("_")[0]
                    axes.plot(whole.times, angles[name], color=colour, linewidth=1, label=side)
            for event in result.repetitions:
                if event.start is not None and event.end is not None:
                    shade = palette.faint if event.count % 2 else palette.background
                    axes.axvspan(event.start, event.end, color=shade, alpha=0.5, linewidth=0)
            low, high = axes.get_ylim()
            if high - low < SPAN:
                axes.set_ylim((low + high - SPAN) / 2, (low + high + SPAN) / 2)
            axes.set_title(kind.replace("_", " "), loc="left")
            axes.set_ylabel("degrees")
            axes.legend(loc="upper right", ncols=2)
        axes.set_xlabel("s")
        save(figure, path)
