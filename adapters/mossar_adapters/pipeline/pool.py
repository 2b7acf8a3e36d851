"""Pool: the performers of a pipeline, with what it needs beyond frames in and events out."""

from collections.abc import Mapping

from mossar_stream.errors import SettingsError
from mossar_stream.events import Event
from mossar_stream.performers import Performers
from mossar_stream.segmenter import Segmenter
from mossar_stream.settings import Settings


class Pool(Performers):
    """Performers that can be asked, changed and kept.

    Args:
        settings: Settings of the performers.
    """

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self.settings = settings  # of performers to come

    def find(self, performer: str) -> Segmenter:
        """Return the segmenter of a performer.

        Raises:
            SettingsError: If there is no such performer.
        """
        if performer not in self:
            known = ", ".join(sorted(self.names)[:20]) or "none"
            raise SettingsError(f"no performer called {performer[:40]!r}; there are: {known}")
        return self[performer]

    def change(self, changes: Mapping[str, object], performer: str | None = None) -> None:
        """Change settings while running; the events come with the next frames.

        Args:
            changes: Names and values.
            performer: Whose; None for all, those to come included.

        Raises:
            SettingsError: If a setting is unknown, its value illegal, or it cannot be changed while running;
                nothing is changed then.
        """
        level = Settings.build(overrides=changes).level
        fixed = [name for name in changes if name != "level"]
        if fixed:
            raise SettingsError(f"setting {fixed[0]} cannot be changed while running; level can")
        if performer is not None:
            self.find(performer).level = level
        else:
            self.level = level
            self.settings = self.settings.replace(level=level)

    def reset(self, performer: str) -> list[Event]:
        """End the take of a performer and forget the running range."""
        return self.find(performer).reset("asked for")

    def snapshot(self) -> dict[str, bytes]:
        """Return what all segmenters know."""
        return {name: self[name].snapshot() for name in self.names}

    def restore(self, blobs: Mapping[str, bytes]) -> None:
        """Go on where the segmenters of a snapshot were.

        Raises:
            SnapshotError: If one of them is damaged.
        """
        self._segmenters = {name: Segmenter.restore(blob) for name, blob in blobs.items()}
