"""Pool: the performers of a pipeline."""

from collections.abc import Mapping
from typing import ClassVar

from mossar_stream import Event, Performers, SettingsError


class Pool(Performers):
    """Performers whose settings come as text, and that no setting can make wait for a whole recording."""

    looks_at_times: ClassVar[bool] = False  # the pipeline does, and knows the source; see `odd_times`

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
        if self.settings.replace(**changes).range == "file":
            raise SettingsError("setting range=file needs a whole recording; a stream has none")
        return self.change(performer, **changes)
