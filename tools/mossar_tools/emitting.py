"""Emitting: requested events must be possible, and an output names the events that it leaves out."""

from pathlib import PurePath

from mossar_adapters.address import parse_url
from mossar_adapters.pipeline.emission import Emission
from mossar_stream import Settings
from mossar_tools.console import LOGGER
from mossar_tools.errors import UsageError
from mossar_tools.options import Streaming


def check_emission(streaming: Streaming, settings: Settings, emission: Emission, *, teaches: bool) -> None:
    """Refuse `--emit` of events that this run never has.

    Args:
        streaming: The user's streaming.
        settings: Of the run.
        emission: Of its `emit`.
        teaches: Whether moves may be shown while it runs.

    Raises:
        UsageError: If no event of a wanted type can come; it names the missing option.
    """
    if not streaming.emit:
        return
    controlled = bool(streaming.control)  # settings may change
    missing = {
        "move": "" if streaming.moves or teaches else "--moves FILE",
        "pose": "" if streaming.moves or teaches else "--moves FILE with poses",
        "follow": "" if streaming.follow or controlled else "--follow NAMES",
        "repetition": "" if settings.repetitions or controlled else "--repetitions",
        "phase": "" if settings.phase or controlled else "--set repetitions=true --set phase=true",
        "step": "" if settings.steps or controlled else "--steps",
        "stats": "" if streaming.stats else "--stats SECONDS",
    }
    for word in streaming.emit:
        kind = word.partition(".")[0]
        if missing.get(kind) and kind in emission.kinds:
            raise UsageError(f"--emit {word}: there are none without {missing[kind]}")


def tell_what_tables_leave_out(streaming: Streaming, settings: Settings) -> None:
    """Warn of steps, which the table of a stream has no place for."""
    tables = [url for url in streaming.to if PurePath(parse_url(url).path).suffix.lower() == ".csv"]
    if tables and settings.steps:
        LOGGER.warning(
            "%s has no rows for steps; they go to a .jsonl file, or for a recording into the table of mossar segment --csv",
            tables[0],
        )
