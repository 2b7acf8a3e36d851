"""Listening: what a source hears besides frames."""

from collections.abc import Callable, Sequence
from typing import Any


class Ears:
    """Implements `Listener`; given to a source when it is opened, told whom to obey when there is somebody."""

    def __init__(self) -> None:
        self._obey: Callable[[str, Sequence[Any]], None] | None = None

    def let_control(self, obey: Callable[[str, Sequence[Any]], None]) -> None:
        """Pass `/mossar/set/<name>` and `/mossar/reset` on; without this they are ignored."""
        self._obey = obey

    def control(self, address: str, arguments: Sequence[Any]) -> None:
        """Act on a control message."""
        if self._obey is not None:
            self._obey(address, arguments)
