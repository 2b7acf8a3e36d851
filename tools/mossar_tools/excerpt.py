"""Excerpt: the part of a recording in a picture, from one time to another."""

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import CurveState, KeyFrame, Result, Segment, Segmentation


class Excerpt(msgspec.Struct, frozen=True):
    """The results between two times.

    Args:
        start: s.
        end: s.
        columns: (n, 4) time (s), velocity, ceiling, floor (shares of the range), one row a frame.
        threshold: Share of the range.
        kept: Key frames that stand, in order of time.
        merged: The others.
        segments: Those that lie in it, even partly.
        cuts: Times of the true cuts, s.
        hierarchy: All key frames of the recording in the order in which they fall.
        whole: Where the recording begins and ends, s.
        level: Strength from which key frames stand.
        level_name: Its name.
        limbs: Segments of each limb that lie in it.
        about: The text of the title; None counts frames and key frames.
        repetitions: Begin, end (s) and number in the bout of those in it.
        moves: Begin, end (s) and name of those in it.
    """

    start: float
    end: float
    columns: NDArray[np.float64]
    threshold: float
    kept: list[KeyFrame]
    merged: list[KeyFrame]
    segments: list[Segment]
    cuts: list[float]
    hierarchy: Sequence[KeyFrame]
    whole: tuple[float, float]
    level: float
    level_name: str
    limbs: dict[str, list[Segment]] = {}  # msgspec copies it
    about: str | None = None
    repetitions: list[tuple[float, float, int]] = []  # the same
    moves: list[tuple[float, float, str]] = []  # the same


def excerpt(
    whole: LoadedRecording,
    result: Result,
    chosen: Segmentation,
    *,
    count: int | None = None,
    columns: NDArray[np.float64] | None = None,
    threshold: float = 0.0,
    level: tuple[float, str] | None = None,
) -> Excerpt:
    """Return the excerpt to draw.

    Args:
        whole: The recording.
        result: Its result.
        chosen: The level to show.
        count: Number of key frames asked for, if it was not a level.
        columns: (n, 4) the curve, if `result` has none.
        threshold: The one of that curve.
        level: Strength from which key frames stand and what to call it, if not those of the result's settings.
    """
    start, end = (float(whole.times[0]), float(whole.times[-1])) if len(whole.times) else (0.0, 1.0)
    if columns is None:
        columns = curve_columns(result.curves)[:, :4]
        threshold = result.curves[0].threshold if result.curves else 0.0
    kept = [key for key in chosen.key_frames if start <= key.time <= end]
    merged = result.hierarchy[: len(result.hierarchy) - len(chosen.key_frames)]
    strength, name = level or _level(result, chosen, count)
    return Excerpt(
        start,
        max(end, start + 1e-3),
        columns[(columns[:, 0] >= start) & (columns[:, 0] <= end)],
        threshold,
        kept,
        sorted((key for key in merged if start <= key.time <= end), key=lambda key: key.time),
        _within(chosen.segments, start, end),
        [cut.time for cut in whole.cuts if start <= cut.time <= end],
        result.hierarchy,
        (start, end),
        strength,
        name,
        limbs={
            limb: _within(chosen_of(own, count).segments, start, end) for limb, own in result.limbs.items()
        },
        repetitions=[
            (event.start, event.end, event.count)
            for event in result.repetitions
            if event.start is not None and event.end is not None and start <= event.start < event.end <= end
        ],
        moves=[
            (event.start, event.end, event.name)
            for event in result.moves
            if start <= event.start < event.end <= end
        ],
    )


def chosen_of(result: Result, count: int | None) -> Segmentation:
    """Return the level of the settings, or so many key frames."""
    return result.at(count=count) if count is not None else result.at(result.settings.level)


def _within(segments: Sequence[Segment], start: float, end: float) -> list[Segment]:
    return [part for part in segments if part.end_time > start and part.start_time < end]


def curve_columns(states: Sequence[CurveState]) -> NDArray[np.float64]:
    """Return a curve as (n, 5): time (s), velocity, ceiling, floor (shares of the range), and whether it is moving.

    It is drawn at the reported positions of its key frames.
    """
    rows = [(s.reported_time, s.value, s.ceiling, s.floor, s.moving) for s in states]
    columns = np.array(rows, np.float64).reshape(-1, 5)
    columns[:, 0] = np.maximum.accumulate(columns[:, 0])  # noise may have grown loud
    return columns


def _level(result: Result, chosen: Segmentation, count: int | None) -> tuple[float, str]:
    """Return the strength from which key frames stand, and what to call it."""
    settings = result.settings
    if count is None:
        strength = settings.strength(settings.level)
        word = "level" if strength == settings.level else settings.level
        return strength, f"{word}\n{strength:.2f}"
    merged = result.hierarchy[: len(result.hierarchy) - len(chosen.key_frames)]
    kept = result.hierarchy[len(merged) :]
    low = merged[-1].strength if merged else 0.0
    high = kept[0].strength if kept else low * 1.2
    return (low + high) / 2, f"{len(kept)}\nkept"
