"""Figures: the common part of all pictures, their style and files."""

from pathlib import Path
from typing import Any, BinaryIO

from mossar_adapters.files.replacing import Draft
from mossar_stream import MossarError
from mossar_tools.errors import UsageError
from mossar_tools.palette import Palette

PICTURES = (".png", ".svg", ".pdf")
DPI = 160
FONT = 8.5


def check_picture(path: str) -> Path:
    """Return the path of a picture to be.

    Raises:
        UsageError: If pictures of that kind cannot be drawn.
        MossarError: If matplotlib is missing.
    """
    if Path(path).suffix.lower() not in PICTURES:
        raise UsageError(f"{path}: pictures are {', '.join(PICTURES)}")
    try:
        import matplotlib as mpl  # noqa: F401 - whether it is there
    except ImportError:
        from mossar_adapters.extras import install_line

        raise MossarError(f"pictures need an extra: {install_line('plot')}") from None
    return Path(path)


def style(palette: Palette) -> Any:
    """Return matplotlib's settings for the colours of a palette."""
    return {
        "font.family": "sans-serif",
        "font.size": FONT,
        "figure.facecolor": palette.background,
        "savefig.facecolor": palette.background,
        "axes.facecolor": palette.background,
        "axes.edgecolor": palette.muted,
        "axes.labelcolor": palette.ink,
        "axes.titlecolor": palette.ink,
        "axes.titlesize": FONT + 1,
        "axes.linewidth": 0.6,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "text.color": palette.ink,
        "xtick.color": palette.muted,
        "ytick.color": palette.muted,
        "xtick.labelsize": FONT - 1,
        "ytick.labelsize": FONT - 1,
        "legend.frameon": False,
        "legend.fontsize": FONT - 1,
        "svg.fonttype": "none",
        "pdf.fonttype": 42,
    }


def save(figure: Any, path: Path | BinaryIO) -> None:
    """Write a figure into a file, one that is open as PNG.

    Raises:
        MossarError: If the file cannot be written.
    """
    try:
        if isinstance(path, Path):
            with Draft(path) as draft:
                figure.savefig(draft.path, dpi=DPI)
        else:
            figure.savefig(path, dpi=DPI)
    except OSError as error:
        raise MossarError(f"{path}: cannot be written: {error.strerror or error}") from None
