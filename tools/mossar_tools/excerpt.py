"""Excerpt: the part of a recording in a picture, from one time to another."""

from collections.abc import Sequence

import msgspec

from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import Result, Segmentation
from mossar_tools.marks import (
    Chart,
    Curve,
    Mark,
    NamedMove,
    curve_columns,
    curve_of,
    mark_of,
    marks_of,
    stretches_of,
)


class Excerpt(Chart, frozen=True, kw_only=True):
    """The results between two times; see `Chart`, too.

    Args:
        cuts: Times of the true cuts, s.
        hierarchy: All key frames of the recording in the order in which they fall.
        whole: Where the recording begins and ends, s.
        level: Strength from which key frames stand.
        level_name: Its name.
        about: Text of the title; None counts frames and key frames.
        repetitions: Begin, end (s) and number in the bout of those in it.
    """

    cuts: list[float]
    hierarchy: Sequence[Mark]
    whole: tuple[float, float]
    level: float
    level_name: str
    about: str | None = None
    repetitions: list[tuple[float, float, int]] = msgspec.field(default_factory=list)


def excerpt(
    whole: LoadedRecording,
    result: Result,
    chosen: Segmentation,
    *,
    count: int | None = None,
    curve: Curve | None = None,
    threshold: float = 0.0,
    level: tuple[float, str] | None = None,
) -> Excerpt:
    """Return the excerpt to draw.

    Args:
        whole: The recording.
        result: Its result.
        chosen: The level to show.
        count: Wanted number of key frames, if not a level.
        curve: The curve, if `result` has none.
        threshold: The one of that curve.
        level: Strength from which key frames stand and its name, if not those of the result's settings.
    """
    start, end = (float(whole.times[0]), float(whole.times[-1])) if len(whole.times) else (0.0, 1.0)
    if curve is None:
        curve = curve_of(curve_columns(result.curves))
        threshold = result.curves[0].threshold if result.curves else 0.0
    everything = Chart(
        start=start,
        end=end,
        threshold=threshold,
        curve=curve,
        marks=marks_of(result, chosen),
        stretches=stretches_of(chosen.segments),
        limbs={limb: stretches_of(chosen_of(own, count).segments) for limb, own in result.limbs.items()},
        moves=[NamedMove(event.start, event.end, event.name) for event in result.moves],
    )
    strength, name = level or _level(result, chosen, count)
    return Excerpt(
        **msgspec.structs.asdict(everything.within(start, max(end, start + 1e-3))),
        cuts=[cut.time for cut in whole.cuts if start <= cut.time <= end],
        hierarchy=[mark_of(key, kept=False) for key in result.hierarchy],
        whole=(start, end),
        level=strength,
        level_name=name,
        repetitions=[
            (event.start, event.end, event.count)
            for event in result.repetitions
            if event.start is not None and event.end is not None and start <= event.start < event.end <= end
        ],
    )


def chosen_of(result: Result, count: int | None) -> Segmentation:
    """Return the level of the settings, or so many key frames."""
    return result.at(count=count) if count is not None else result.at(result.settings.level)


def _level(result: Result, chosen: Segmentation, count: int | None) -> tuple[float, str]:
    """Return the strength from which key frames stand, and its name."""
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
