"""Listening: what a source hears besides frames, handed to the pipeline it feeds."""

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mossar_adapters.pipeline.pipeline import Pipeline

SETTLE = 0.05  # s for the last frames of a performer who has left to come through the queue


class Ears:
    """Implements `Listener`; given to a source when it is opened, tied to a pipeline when there is one."""

    def __init__(self) -> None:
        self._pipeline: Pipeline | None = None
        self._source = -1
        self._obey: Callable[[str, Sequence[Any]], None] | None = None

    def tie(self, pipeline: "Pipeline", source: int) -> None:
        """Tell what is heard to a pipeline.

        Args:
            pipeline: The pipeline.
            source: Index of the source that hears.
        """
        self._pipeline, self._source = pipeline, source

    def let_control(self, obey: Callable[[str, Sequence[Any]], None]) -> None:
        """Pass `/mossar/set/<name>` and `/mossar/reset` on; without this they are ignored."""
        self._obey = obey

    def lost(self, performer: str, reason: str) -> None:
        """End the take of a performer who has left."""
        pipeline, source = self._pipeline, self._source
        if pipeline is not None:
            due = time.monotonic() + SETTLE
            pipeline.ask(lambda: pipeline.upkeep.let_go(pipeline, source, performer, reason, due))

    def control(self, address: str, arguments: Sequence[Any]) -> None:
        """Act on a control message."""
        if self._obey is not None:
            self._obey(address, arguments)
