"""Marks: the content of a chart of a segmentation. `panels` draws it with matplotlib, `dashboard.chart` as SVG."""

from collections.abc import Iterable, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import CurveState, KeyFrame, KeyFrameKind, Result, Segment, Segmentation, SegmentState

_LEAST = 0.25  # share of the range that the axis of velocities always reaches


class Mark(msgspec.Struct, frozen=True):
    """A key frame in a chart.

    Args:
        id: Identifier of the key frame among those of its performer.
        time: s.
        frame: Number of the frame.
        kind: `onset`, `offset` or `minimum`.
        velocity: Share of the range.
        strength: Cost of the merge that removes it; None until first computed.
        kept: Whether it is kept at the level shown.
        decided: Whether the segmenter will not change it any more.
        tentative: Whether it is only a candidate.
        delay: Time from the key frame to the event that confirmed it, s; None in recordings.
    """

    id: str
    time: float
    frame: int
    kind: KeyFrameKind
    velocity: float
    strength: float | None
    kept: bool
    decided: bool = True
    tentative: bool = False
    delay: float | None = None


class Stretch(msgspec.Struct, frozen=True):
    """A segment in a chart."""

    start: float  # s
    end: float  # s
    state: SegmentState


class NamedMove(msgspec.Struct, frozen=True):
    """A move that was recognised."""

    start: float  # s
    end: float  # s
    name: str


class Curve(msgspec.Struct, frozen=True):
    """The velocity curve, all (n,) and shares of the range but `times` in s."""

    times: NDArray[np.float64]
    value: NDArray[np.float64]
    ceiling: NDArray[np.float64]
    floor: NDArray[np.float64]

    def thinned(self, most: int) -> "Curve":
        """Return samples at a constant stride, so that fewer than twice `most` are left."""
        step = max(1, len(self.times) // most)
        return Curve(self.times[::step], self.value[::step], self.ceiling[::step], self.floor[::step])


class Chart(msgspec.Struct, frozen=True, kw_only=True):
    """The marks of a segmentation between two times.

    Args:
        start: Start of the chart, s.
        end: End of the chart, s.
        threshold: Share of the range.
        curve: Velocity within the chart.
        marks: Key frames within the chart, in order of time.
        stretches: Segments within the chart at the level shown.
        limbs: Segments of each limb within the chart.
        moves: Moves recognised within the chart.
    """

    start: float
    end: float
    threshold: float
    curve: Curve
    marks: list[Mark]
    stretches: list[Stretch]
    limbs: dict[str, list[Stretch]] = {}  # msgspec copies it
    moves: list[NamedMove] = []  # the same

    @property
    def kept(self) -> list[Mark]:
        """Key frames that are kept at the level shown."""
        return [mark for mark in self.marks if mark.kept]

    @property
    def merged(self) -> list[Mark]:
        """Key frames that are merged at the level shown, without candidates."""
        return [mark for mark in self.marks if not mark.kept and not mark.tentative]

    @property
    def top(self) -> float:
        """The upper end of the axis of velocities."""
        peaks = (mark.velocity for mark in self.marks)
        return 1.1 * max(
            _LEAST, float(np.nanmax(self.curve.value, initial=0.0)), *peaks, 1.6 * self.threshold
        )

    def height(self, mark: Mark) -> float:
        """Return the velocity at the reported time of a key frame; `Mark.velocity` is that at Algorithm 2's frame."""
        seen = np.isfinite(self.curve.value)
        if not seen.any():
            return mark.velocity
        return float(np.interp(mark.time, self.curve.times[seen], self.curve.value[seen]))

    def within(self, start: float, end: float) -> "Chart":
        """Return the marks between two times, and the curve up to its samples beside them."""
        first, last = np.searchsorted(self.curve.times, [start, end])
        part = slice(max(0, int(first) - 1), int(last) + 1)
        curve = self.curve
        return Chart(
            start=start,
            end=end,
            threshold=self.threshold,
            curve=Curve(curve.times[part], curve.value[part], curve.ceiling[part], curve.floor[part]),
            marks=[mark for mark in self.marks if start <= mark.time <= end],
            stretches=_overlapping(self.stretches, start, end),
            limbs={name: _overlapping(parts, start, end) for name, parts in self.limbs.items()},
            moves=[move for move in self.moves if start <= move.start < move.end <= end],
        )


def _overlapping(parts: Iterable[Stretch], start: float, end: float) -> list[Stretch]:
    return [part for part in parts if part.end > start and part.start < end]


def curve_columns(states: Sequence[CurveState]) -> NDArray[np.float64]:
    """Return a curve as (n, 5): time (s), velocity, ceiling, floor (shares of the range), and whether it is moving.

    Its times are reported times, like those of its key frames.
    """
    rows = [(s.reported_time, s.value, s.ceiling, s.floor, s.moving) for s in states]
    columns = np.array(rows, np.float64).reshape(-1, 5)
    columns[:, 0] = np.maximum.accumulate(columns[:, 0])  # rising noise may turn them back
    return columns


def curve_of(columns: NDArray[np.float64]) -> Curve:
    """Return the curve of `curve_columns`."""
    return Curve(*columns[:, :4].T)


def mark_of(key: KeyFrame, *, kept: bool) -> Mark:
    """Return the mark of a key frame of a recording."""
    return Mark(str(key.frame), key.time, key.frame, key.kind, key.velocity, key.strength, kept)


def marks_of(result: Result, chosen: Segmentation) -> list[Mark]:
    """Return the marks of a recording's key frames at a level, in order of time."""
    merged = result.hierarchy[: len(result.hierarchy) - len(chosen.key_frames)]
    marks = [mark_of(key, kept=True) for key in chosen.key_frames]
    marks += [mark_of(key, kept=False) for key in merged]
    return sorted(marks, key=lambda mark: mark.time)


def stretches_of(segments: Iterable[Segment]) -> list[Stretch]:
    """Return the segments of a recording as stretches."""
    return [Stretch(part.start_time, part.end_time, part.state) for part in segments]
