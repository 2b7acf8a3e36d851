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

    def change(self, changes: Mapping[str, object], performer: str | None = None) -> list[Event]:  # type: ignore[override]
        """Change settings while running, see `Segmenter.change`; more events may come with the next frames.

        Args:
            changes: Names and values.
            performer: Whose; None for all, those to come included.

        Returns:
            The events of takes that this ends.

        Raises:
            SettingsError: If a setting is unknown, its value illegal, or of no use to a stream; nothing is
                changed then.
        """
        changed = self.settings.replace(**changes)
        if changed.range == "file":
            raise SettingsError("setting range=file needs a whole recording; a stream has none")
        if performer is not None:
            return self.find(performer).change(**changes)
        self.settings = changed
        return super().change(None, **changes)

    def snapshot(self) -> dict[str, bytes]:
        """Return what all segmenters know."""
        return {name: self[name].snapshot() for name in self.names}

    def restore(self, blobs: Mapping[str, bytes]) -> None:
        """Go on where the segmenters of a snapshot were.

        Raises:
            SnapshotError: If one of them is damaged.
        """
        self._segmenters = {name: Segmenter.restore(blob) for name, blob in blobs.items()}
