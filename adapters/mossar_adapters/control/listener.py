"""Control messages that a source receives besides frames."""

from collections.abc import Callable, Sequence
from typing import Any


class ControlListener:
    """Implements `Listener`: a source gets it when it is opened; requests are ignored until `pass_on_to` is called."""

    def __init__(self) -> None:
        self._apply: Callable[[str, Sequence[Any]], None] | None = None

    def pass_on_to(self, apply: Callable[[str, Sequence[Any]], None]) -> None:
        """Pass `/mossar/set/<name>` and `/mossar/reset` on; without this they are ignored."""
        self._apply = apply

    def control(self, address: str, arguments: Sequence[Any]) -> None:
        """Act on a control message."""
        if self._apply is not None:
            self._apply(address, arguments)
