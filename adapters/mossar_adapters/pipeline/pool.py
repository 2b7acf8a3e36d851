"""Pool: the segmenters of all performers, and the settings that new ones get."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from mossar_stream.errors import FrameError, SettingsError
from mossar_stream.events import Event
from mossar_stream.frames import Frames
from mossar_stream.settings import Settings
from mossar_stream.skeleton import Skeleton

if TYPE_CHECKING:
    from mossar_stream.segmenter import Segmenter
    from mossar_stream.state import CurveState

MAX_PERFORMERS = 256  # at a time


class Pool:
    """Routes frames to one segmenter per performer.

    Args:
        settings: Settings of performers to come.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._segmenters: dict[str, Segmenter] = {}

    @property
    def performers(self) -> tuple[str, ...]:
        """Names of the performers, in the order of their coming."""
        return tuple(self._segmenters)

    def announce(self, performer: str, skeleton: Skeleton, fps: float | None) -> list[Event]:
        """Take note of a performer; another skeleton than before ends the take.

        Raises:
            FrameError: If there are too many performers.
        """
        from mossar_stream.segmenter import Segmenter  # loads the compiler

        known = self._segmenters.get(performer)
        if known is not None and known.skeleton == skeleton:
            return []
        if known is None and len(self._segmenters) >= MAX_PERFORMERS:
            raise FrameError(f"more than {MAX_PERFORMERS} performers at once; {performer} is left out")
        events = known.end_take("another skeleton") if known is not None else []
        self._segmenters[performer] = Segmenter(skeleton, self.settings, performer, fps)
        return events

    def push(self, frames: Frames) -> list[Event]:
        """Take frames in.

        Raises:
            FrameError: If the performer was not announced or the frames do not fit the skeleton.
        """
        if frames.performer not in self._segmenters:
            raise FrameError(f"performer {frames.performer} was not announced")
        return self._segmenters[frames.performer].push(frames)

    def end_take(self, performer: str, reason: str) -> list[Event]:
        """End the take of a performer."""
        return self._segmenters[performer].end_take(reason)

    def reset(self, performer: str) -> list[Event]:
        """End the take of a performer and forget the running range."""
        return self._segmenters[performer].reset()

    def change(self, changes: Mapping[str, object], performer: str | None = None) -> list[list[Event]]:
        """Change settings while running; events of the undecided key frames come with the next frames.

        Args:
            changes: Names and values.
            performer: Whose; None for all, those to come included.

        Returns:
            Events of each performer.

        Raises:
            SettingsError: If a setting is unknown, its value illegal, or it cannot be changed while running;
                nothing is changed then.
        """
        level = Settings.build(overrides=changes).level
        fixed = [name for name in changes if name != "level"]
        if fixed:
            raise SettingsError(f"setting {fixed[0]} cannot be changed while running; level can")
        names = self.performers if performer is None else (performer,)
        for name in names:
            self._segmenters[name].level = level
        if performer is None:
            self.settings = self.settings.replace(level=level)
        return []

    def segmenter(self, performer: str) -> "Segmenter":
        """Return the segmenter of a performer.

        Raises:
            SettingsError: If there is no such performer.
        """
        if performer not in self._segmenters:
            raise SettingsError(f"no performer called {performer[:40]!r}; there are {', '.join(self.performers)}")
        return self._segmenters[performer]

    def state(self, performer: str) -> "CurveState | None":
        """Return the velocity curve of a performer at the last frame."""
        return self._segmenters[performer].state

    def stats(self, performer: str) -> dict[str, int]:
        """Return the counters of a performer."""
        return self._segmenters[performer].stats

    def take(self, performer: str) -> int:
        """Return the number of the take of a performer."""
        return self._segmenters[performer].take

    def snapshot(self) -> dict[str, bytes]:
        """Return what all segmenters know."""
        return {name: segmenter.snapshot() for name, segmenter in self._segmenters.items()}

    def restore(self, blobs: Mapping[str, bytes]) -> None:
        """Go on where the segmenters of a snapshot were.

        Raises:
            SnapshotError: If one of them is damaged.
        """
        from mossar_stream.segmenter import Segmenter  # loads the compiler

        self._segmenters = {name: Segmenter.restore(blob) for name, blob in blobs.items()}
