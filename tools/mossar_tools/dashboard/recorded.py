"""Recorded: the show of a whole recording, segmented offline, with a playhead."""

import io
import re
import threading
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files import open_recording
from mossar_adapters.files.loaded import LoadedRecording
from mossar_adapters.files.options import ReadOptions
from mossar_stream import LevelName, Result, Segmentation, Settings, segment_recording
from mossar_tools.console import progress_of
from mossar_tools.dashboard.glimpse import Body, Ghost, Glimpse
from mossar_tools.dashboard.levels import needs_other_bundle, strength_of
from mossar_tools.dashboard.motion import Motion
from mossar_tools.dashboard.placement import Placement
from mossar_tools.dashboard.player import Player
from mossar_tools.dashboard.track import GHOSTS, SECONDS
from mossar_tools.excerpt import excerpt
from mossar_tools.figures import check_picture
from mossar_tools.loaded_recording import load_recording
from mossar_tools.marks import Chart, Mark, curve_columns, curve_of, marks_of, stretches_of
from mossar_tools.palette import Palette

MOST_PERFORMERS = 4  # shown
AHEAD = 5.0  # s of the chart that lie before the playhead
_POSES = 300  # that the directions are found from
_POINTS = 900  # of the curve


class _Segmented(msgspec.Struct, frozen=True):
    """The results of a recording.

    Args:
        result: Key frames and their hierarchy.
        columns: (n, 5) time (s), velocity, ceiling, floor (shares of the range), and whether it is moving.
        threshold: Share of the range.
    """

    result: Result
    columns: NDArray[np.float64]
    threshold: float


class _Part:
    """One performer: frames, their result, and the shown level."""

    def __init__(self, performer: str, whole: LoadedRecording, settings: Settings) -> None:
        self.performer = performer
        self.whole = whole
        self.placement = Placement(whole.skeleton)
        for pose in whole.positions[:: max(1, len(whole.positions) // _POSES)]:
            self.placement.learn(pose)
        self.found = _segmented(whole, settings)

    def choose(self, chosen: Segmentation) -> None:
        """Show a level."""
        self.chosen = chosen
        columns = self.found.columns
        self.chart = Chart(
            start=float(columns[0, 0]) if len(columns) else 0.0,
            end=float(columns[-1, 0]) if len(columns) else 0.0,
            threshold=self.found.threshold,
            curve=curve_of(columns),
            marks=marks_of(self.found.result, chosen),
            stretches=stretches_of(chosen.segments),
        )


class RecordedShow:
    """Plays recordings that have been segmented as a whole.

    Args:
        parts: Name and frames of each performer.
        settings: Of the segmentation.
        speed: Of the player.
    """

    recorded = True

    def __init__(
        self, parts: list[tuple[str, LoadedRecording]], settings: Settings, speed: float = 1.0
    ) -> None:
        self.settings = settings
        self.level: LevelName | float = settings.level
        self.count: int | None = None  # wanted number of key frames, None while the level decides
        self.version = 0  # another one after each change in the view of the whole recording
        self._parts = [_Part(name, whole, settings) for name, whole in parts]
        times = [whole.times for _, whole in parts if len(whole.times)]
        ends = (min(t[0] for t in times), max(t[-1] for t in times)) if times else (0.0, 0.0)
        self.player = Player(float(ends[0]), float(ends[1]), speed)
        self._lock = threading.Lock()
        self._choose()

    @property
    def total(self) -> int:
        """Number of key frames that Algorithm 2 has found in the first recording."""
        return len(self._parts[0].found.result.key_frames)

    @property
    def kept(self) -> int:
        """Number of those that stand."""
        return len(self._parts[0].chart.kept)

    @property
    def strength(self) -> float:
        """The level shown as a strength."""
        hierarchy = self._parts[0].found.result.hierarchy
        if self.count is None:
            return self.strength_of(self.level)
        merged = len(hierarchy) - self.count
        if merged < len(hierarchy):
            return float(hierarchy[merged].strength)
        return 1.01 * hierarchy[-1].strength if hierarchy else 0.0

    def strength_of(self, level: LevelName | float) -> float:
        """Return the strength that a level stands for."""
        return strength_of(self.settings, level)

    def set_level(self, level: LevelName | float) -> None:
        """Show a level. A number is a strength within the present result; a name is that of `--level`.

        A name whose bundle is another one is segmented for anew, because its strengths are of other features.
        """
        settings = self.settings.replace(level=level) if isinstance(level, str) else self.settings
        found = self._segmented(settings) if needs_other_bundle(self.settings, level) else None
        with self._lock:
            self.settings, self.level, self.count = settings, level, None
            self._choose(found)

    def set_count(self, count: int) -> None:
        """Show so many key frames."""
        with self._lock:
            self.count = min(max(count, 0), self.total)
            self._choose()

    def step_count(self, step: int) -> None:
        """Show so many key frames more, or less if negative."""
        with self._lock:
            self.count = min(max(self.kept + step, 0), self.total)
            self._choose()

    def change(self, changes: dict[str, object]) -> None:
        """Segment anew with other settings.

        Raises:
            SettingsError: If a value is illegal.
        """
        settings = self.settings.replace(**changes)
        found = self._segmented(settings)
        with self._lock:
            self.settings = settings
            self._choose(found)

    def _segmented(self, settings: Settings) -> list[_Segmented]:
        """Return the result with other settings; meanwhile the earlier one is shown."""
        return [_segmented(part.whole, settings) for part in self._parts]

    def reset(self) -> None:
        """Go back to the beginning."""
        self.player.seek(self.player.start)

    def visit(self, time: float) -> None:
        """Go to a key frame and stop there."""
        self.player.paused = True
        self.player.seek(time)

    def marks(self) -> list[tuple[str, Mark]]:
        """Return all key frames with their performers."""
        with self._lock:
            return [(part.performer, mark) for part in self._parts for mark in part.chart.marks]

    def picture(self, palette: Palette) -> tuple[str, bytes]:
        """Return the first performer's name, and the shown picture of the whole recording as a PNG.

        Raises:
            MossarError: If matplotlib is missing.
        """
        check_picture("whole.png")
        from mossar_tools.plot import draw_excerpt

        with self._lock:
            part, found, chosen = self._parts[0], self._parts[0].found, self._parts[0].chosen
            word = "level" if self.count is not None or not isinstance(self.level, str) else self.level
            level = (self.strength, f"{word}\n{self.strength:.2f}")
        target = io.BytesIO()
        shown = excerpt(
            part.whole, found.result, chosen, curve=part.chart.curve, threshold=found.threshold, level=level
        )
        draw_excerpt(target, part.whole, shown, palette)
        return part.performer, target.getvalue()

    @property
    def name(self) -> str:
        """The recording's name, as part of file names."""
        return re.sub(r"[^\w.-]+", "-", Path(self._parts[0].whole.name).stem).strip("-") or "recording"

    def outlines(self) -> list[Chart]:
        """Return the outlines of the whole recording, one for each performer."""
        with self._lock:
            return [part.chart for part in self._parts]

    def glimpses(self) -> list[Glimpse]:
        """Return the view at the playhead, one performer each."""
        place = self.player.place
        with self._lock:
            return [self._glimpse(part, place) for part in self._parts if len(part.found.columns)]

    def _choose(self, found: list[_Segmented] | None = None) -> None:
        """Show the level, of something newly found if it is given."""
        self.version += 1
        for part, new in zip(self._parts, found or (), strict=False):
            part.found = new
        for part in self._parts:
            if self.count is not None:
                part.choose(part.found.result.at(count=self.count))
            else:
                part.choose(part.found.result.at(self.strength_of(self.level)))

    def _glimpse(self, part: _Part, place: float) -> Glimpse:
        seen = part.chart.within(*self._window(place))
        times = part.chart.curve.times
        now = min(int(np.searchsorted(times, place)), len(times) - 1)
        past = [mark for mark in part.chart.kept if mark.time <= place]
        return Glimpse(
            **msgspec.structs.asdict(msgspec.structs.replace(seen, curve=seen.curve.thinned(_POINTS))),
            performer=part.performer,
            skeleton=part.whole.skeleton,
            now=place,
            moving=bool(part.found.columns[now, 4]),
            body=self._body(part, place),
            ghosts=[
                Ghost(mark, part.placement.place(part.whole.positions[mark.frame])) for mark in past[-GHOSTS:]
            ],
            statistics=[
                ("recording", part.whole.name.rsplit("/", 1)[-1]),
                ("frames", f"{len(part.whole.times):,}"),
                ("rate", f"{part.whole.fps:g} fps" if part.whole.fps else "as timed"),
                ("length", f"{self.player.end - self.player.start:.1f} s"),
            ],
        )

    def _window(self, place: float) -> tuple[float, float]:
        player = self.player
        if player.end - player.start <= SECONDS:
            return player.start, max(player.end, player.start + 1.0)
        start = min(max(place - SECONDS + AHEAD, player.start), player.end - SECONDS)
        return start, start + SECONDS

    @staticmethod
    def _body(part: _Part, place: float) -> Body | None:
        times, positions = part.whole.times, part.whole.positions
        at = min(int(np.searchsorted(times, place)), len(times) - 1)
        motion = Motion(part.whole.skeleton)
        for i in _before(times, at):
            motion.take(float(times[i]), positions[i])
        return Body(part.placement.place(positions[at]), motion.shares())


def _segmented(whole: LoadedRecording, settings: Settings) -> _Segmented:
    """Return the result of a recording, with only the drawn part of its curve."""
    result = segment_recording(
        whole.positions,
        whole.fps,
        whole.skeleton,
        settings,
        times=whole.times,
        curves=True,
        takes=True,
        on_progress=progress_of(f"segmenting {whole.name}"),
    )
    states = result.curves
    columns = curve_columns(states)
    threshold = states[-1].threshold if states else 0.0
    states.clear()
    return _Segmented(result, columns, threshold)


def _before(times: NDArray[np.float64], at: int) -> list[int]:
    """Return a few frames up to one, over about half a second."""
    first = int(np.searchsorted(times, times[at] - 0.4))
    return sorted({*range(at, first - 1, -max(1, (at - first) // 10)), at})


def read_parts(file: str, reading: ReadOptions) -> list[tuple[str, LoadedRecording]]:
    """Return name and frames of each performer of a recording.

    Raises:
        MossarError: If it cannot be read.
    """
    recording = open_recording(file, reading)
    if len(recording.performers) < 2 or reading.performer is not None:
        return [(reading.performer or recording.performers[0], load_recording(file, reading))]
    names = recording.performers[:MOST_PERFORMERS]
    return [(name, load_recording(file, msgspec.structs.replace(reading, performer=name))) for name in names]
