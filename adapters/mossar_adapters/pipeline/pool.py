"""Pool: the performers of a pipeline, with what it needs beyond frames in and events out."""

from collections.abc import Mapping

from mossar_stream.errors import SettingsError
from mossar_stream.events import Event
from mossar_stream.performers import Performers
from mossar_stream.segmenter import Segmenter


class Pool(Performers):
    """Performers whose settings come as text, and that can be kept and restored."""

    def set(self, changes: Mapping[str, object], performer: str | None = None) -> list[Event]:
        """Change settings while running.

        Args:
            changes: Names and values as for `Settings.build`.
            performer: Whose; None for all, those to come included.

        Returns:
            The events of takes that this ends.

        Raises:
            SettingsError: If a name is unknown, a value illegal or of no use to a stream; nothing is changed
                then.
            FrameError: If there is no such performer.
        """
        if self._settings.replace(**changes).range == "file":
            raise SettingsError("setting range=file needs a whole recording; a stream has none")
        return self.change(performer, **changes)

    def snapshot(self) -> dict[str, bytes]:
        """Return what all segmenters know."""
        return {name: self[name].snapshot() for name in self.names}

    def restore(self, blobs: Mapping[str, bytes]) -> None:
        """Go on where the segmenters of a snapshot were.

        Raises:
            SnapshotError: If one of them is damaged.
        """
        self._segmenters = {name: Segmenter.restore(blob) for name, blob in blobs.items()}
