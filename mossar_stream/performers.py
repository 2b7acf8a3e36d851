"""Performers: segmenters by name, for streams in which several people move."""

from collections.abc import Mapping

from mossar_stream.errors import FrameError
from mossar_stream.events import Event
from mossar_stream.frames import Frames, performer_name
from mossar_stream.segmenter import Segmenter
from mossar_stream.settings import LevelName, Settings
from mossar_stream.skeleton import Skeleton

MOST_PERFORMERS = 1024


class Performers:
    """A pool of segmenters with the same settings, one for each performer that is announced.

    Args:
        settings: Defaults to `Settings()`.
        most: How many performers are followed at once; the one idle for longest makes room for a new one.

    Example:
        >>> import numpy as np
        >>> pool = Performers()
        >>> _ = pool.announce("ann", Skeleton(("hip", "hand"), (-1, 0)))
        >>> events = pool.push(Frames(np.zeros((1, 2, 3), np.float32), np.zeros(1), performer="ann"))
        >>> events[0].event
        'started'
    """

    def __init__(self, settings: Settings | None = None, most: int = MOST_PERFORMERS) -> None:
        if most < 1:
            raise ValueError(f"at least one performer must be followed, not {most}")
        self._settings = settings or Settings()
        self._level = self._settings.level
        self._most = most
        self._segmenters: dict[str, Segmenter] = {}  # in the order in which they were last used

    def __contains__(self, performer: str) -> bool:
        return performer in self._segmenters

    def __getitem__(self, performer: str) -> Segmenter:
        return self._segmenters[performer]

    def __len__(self) -> int:
        return len(self._segmenters)

    @property
    def names(self) -> tuple[str, ...]:
        """The performers that are followed."""
        return tuple(self._segmenters)

    @property
    def settings(self) -> Settings:
        """Settings of the performers to come; `level` as it is now."""
        return self._settings.replace(level=self._level)

    def announce(self, performer: str, skeleton: Skeleton, fps: float | None = None) -> list[Event]:
        """Take note of a performer, or of its new skeleton, which ends its take; the next one has the next number.

        Args:
            performer: Name.
            skeleton: Joints in the order of the frames to come.
            fps: Nominal rate, Hz, if known.

        Returns:
            The events of takes that this ends.
        """
        name = performer_name(performer)
        known = self._segmenters.get(name)
        if known is not None and known.skeleton == skeleton:
            return []
        events = self.remove(name, "another skeleton") if known is not None else []
        while len(self._segmenters) >= self._most:
            events += self.remove(next(iter(self._segmenters)), "too many performers")
        segmenter = Segmenter(skeleton, self._settings, name, fps, known)
        if segmenter.level != self._level:
            segmenter.level = self._level  # the threshold only: the bundle stays that of the settings
        self._segmenters[name] = segmenter
        return events

    def push(self, frames: Frames) -> list[Event]:
        """Take frames of one performer in and return the events they cause.

        Raises:
            FrameError: If the performer was not announced or the shapes do not fit its skeleton.
        """
        name = frames.performer if frames.performer in self._segmenters else performer_name(frames.performer)
        segmenter = self._segmenters.pop(name, None)
        if segmenter is None:
            raise FrameError(f"performer {frames.performer!r} was not announced")
        self._segmenters[name] = segmenter
        return segmenter.push(frames)

    def change(self, performer: str | None = None, **changes: object) -> list[Event]:
        """Change settings of one performer, or of all and of those to come; see `Segmenter.change`.

        Raises:
            SettingsError: If a value is illegal; nothing is changed then.
            FrameError: If there is no such performer.
        """
        if performer is not None:
            if performer not in self._segmenters:
                raise FrameError(
                    f"no performer called {performer!r}; there are {', '.join(self.names) or 'none'}"
                )
            return self._segmenters[performer].change(**changes)
        level = self._settings.replace(level=changes.pop("level", self._level)).level
        self._settings = self._settings.replace(**changes)
        self._level = level
        changes["level"] = level
        return [event for segmenter in self._segmenters.values() for event in segmenter.change(**changes)]

    def reset(self, performer: str | None = None, reason: str = "") -> list[Event]:
        """End the take of one performer, or of all, and forget the running range.

        Raises:
            FrameError: If there is no such performer.
        """
        if performer is not None and performer not in self._segmenters:
            raise FrameError(
                f"no performer called {performer!r}; there are {', '.join(self.names) or 'none'}"
            )
        chosen = self.names if performer is None else (performer,)
        return [event for name in chosen for event in self._segmenters[name].reset(reason)]

    def end_takes(self, reason: str = "") -> list[Event]:
        """End the takes of all performers."""
        return [event for segmenter in self._segmenters.values() for event in segmenter.end_take(reason)]

    def remove(self, performer: str, reason: str = "") -> list[Event]:
        """End a performer's take and forget the performer."""
        return self._segmenters.pop(performer).end_take(reason)

    def snapshot(self) -> dict[str, bytes]:
        """Return what all segmenters know, by performer."""
        return {name: segmenter.snapshot() for name, segmenter in self._segmenters.items()}

    def restore(self, blobs: Mapping[str, bytes]) -> None:
        """Go on where the segmenters of a snapshot were, in place of those that are here.

        Raises:
            SnapshotError: If one of them is damaged; nothing is changed then.
        """
        self._segmenters = {name: Segmenter.restore(blob) for name, blob in blobs.items()}

    @property
    def level(self) -> LevelName | float:
        """The level of all performers; setting it acts at once."""
        return self._level

    @level.setter
    def level(self, level: LevelName | float) -> None:
        self._level = self._settings.replace(level=level).level
        for segmenter in self._segmenters.values():
            segmenter.level = level
