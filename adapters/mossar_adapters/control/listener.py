"""Control messages that a source receives besides frames."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

_MOST_EARLY = 64  # requests that are kept until they can be passed on


class ControlListener:
    """Implements `Listener`: a source gets it when it is opened; requests wait until `pass_on_to` is called."""

    def __init__(self) -> None:
        self._apply: Callable[[str, Sequence[Any]], None] | None = None
        self._early: deque[tuple[str, Sequence[Any]]] = deque(maxlen=_MOST_EARLY)

    def pass_on_to(self, apply: Callable[[str, Sequence[Any]], None]) -> None:
        """Pass `/mossar/set/<name>` and `/mossar/reset` on; without this they are ignored."""
        self._apply = apply
        while self._early:
            apply(*self._early.popleft())

    def control(self, address: str, arguments: Sequence[Any]) -> None:
        """Act on a control message."""
        if self._apply is None:
            self._early.append((address, arguments))
        else:
            self._apply(address, arguments)
