"""Notebook: results as a summary, a table, a picture or a DataFrame.

Results are known by their fields alone, since their classes use this module.
pandas and matplotlib are used where they are installed; no other module of the package uses them.
"""

from collections.abc import Iterable, Sequence
from html import escape
from importlib import import_module
from itertools import pairwise
from typing import Any, TypeVar

import msgspec

_Row = TypeVar("_Row", bound=msgspec.Struct)
ROWS_SHOWN = 12  # rows of a table that are shown
_COLOURS = {"moving": "#f6d28b", "resting": "#d5e2ec"}


def summary(result: Any) -> str:
    """Return one line on a result."""
    keys, kept = result.key_frames, result.at(result.settings.level).key_frames
    return f"Result: {_counted(keys, 'key frame')}, {len(kept)} of them at level {result.settings.level}"


def segments_summary(segmentation: Any) -> str:
    """Return a line on a level and one on each segment, the first ones of many."""
    parts = segmentation.segments
    lines = [f"Segmentation: {_counted(segmentation.key_frames, 'key frame')}, {_counted(parts, 'segment')}"]
    lines += [f"  {p.start_time:9.2f} to {p.end_time:9.2f} s  {p.state}" for p in parts[:ROWS_SHOWN]]
    return "\n".join([*lines, f"  and {len(parts) - ROWS_SHOWN} more"] if len(parts) > ROWS_SHOWN else lines)


def _counted(things: Sequence[Any], name: str) -> str:
    return f"{len(things)} {name}{'' if len(things) == 1 else 's'}"


def html(result: Any) -> str:
    """Return a summary and the segments at the level of the settings, as HTML."""
    return f"<p>{escape(summary(result))}</p>{segments_html(result.at(result.settings.level))}"


def segments_html(segmentation: Any) -> str:
    """Return the segments of a level as an HTML table, the first ones of many."""
    parts = segmentation.segments
    rows = [_row("th", ("start", "end", "state", "most active joints", "similarity"))]
    for part in parts[:ROWS_SHOWN]:
        alike = "" if part.similarity is None else f"{part.similarity:.2f}"
        times = (f"{part.start_time:.2f} s", f"{part.end_time:.2f} s")
        rows.append(_row("td", (*times, part.state, ", ".join(part.active_joints[:3]), alike)))
    more = f"<p>and {len(parts) - ROWS_SHOWN} more</p>" if len(parts) > ROWS_SHOWN else ""
    return f"<table>{''.join(rows)}</table>{more}"


def dataframe(rows: Sequence[msgspec.Struct], fields: Sequence[str]) -> Any:
    """Return records as a pandas DataFrame with a column for each field.

    Raises:
        ImportError: If pandas is not installed; it names the extra.
    """
    pandas = _library("pandas", "notebook", "to_dataframe")
    return pandas.DataFrame([msgspec.structs.asdict(row) for row in rows], columns=list(fields))


class Table(list[_Row]):
    """A list of records that is a table, too.

    Args:
        rows: The records.
        record: Their type.
    """

    def __init__(self, rows: Iterable[_Row], record: type[_Row]) -> None:
        super().__init__(rows)
        self._record = record

    def to_dataframe(self) -> Any:
        """Return the records as a pandas DataFrame with a column for each field.

        Raises:
            ImportError: If pandas is not installed; it names the extra.
        """
        return dataframe(self, self._record.__struct_fields__)


def _library(name: str, extra: str, what: str) -> Any:
    """Return a library that is not required.

    Args:
        name: Of the module.
        extra: Extra of the distribution that brings it.
        what: The name of the feature that needs it.

    Raises:
        ImportError: If it is not installed.
    """
    try:
        return import_module(name)
    except ImportError:
        raise ImportError(f"{what} needs an extra: pip install 'mossar-stream[{extra}]'") from None


def plot(result: Any, segmentation: Any, axes: Any) -> Any:
    """Draw the segments of a level and all key frames, with the velocity curve where it was kept.

    Args:
        result: The result.
        segmentation: The level to show.
        axes: Of matplotlib; a new figure's if None.

    Returns:
        The axes.

    Raises:
        ImportError: If matplotlib is not installed.
    """
    if axes is None:
        axes = _library("matplotlib.pyplot", "plot", "plot").subplots(
            figsize=(10, 2.5), layout="constrained"
        )[1]
    for part in segmentation.segments:
        axes.axvspan(part.start_time, part.end_time, color=_COLOURS[part.state], lw=0)
    for before, _ in pairwise(segmentation.segments):
        axes.axvline(before.end_time, color="#d55e00", lw=1)
    if result.curves:
        axes.plot(
            [at.reported_time for at in result.curves],
            [at.value for at in result.curves],
            color="#1f2430",
            lw=0.8,
        )
    keys = result.key_frames
    axes.plot([key.time for key in keys], [key.velocity for key in keys], "o", color="#0072b2", ms=3)
    axes.set_xlabel("s")
    axes.set_ylabel("velocity, share of the range")
    return axes


def _row(cell: str, texts: Sequence[str]) -> str:
    return "<tr>" + "".join(f"<{cell}>{escape(text)}</{cell}>" for text in texts) + "</tr>"
