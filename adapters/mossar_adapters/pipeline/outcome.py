"""Outcome: how a run went."""

import msgspec

from mossar_stream import MossarError

GUESSED_LIMBS = "limbs follow from the hierarchy, because fewer than 8 joints have names that are known; --limbs NAME=JOINTS names them"
WITHOUT_LIMBS = "no joint of its skeleton can move against another; it is segmented as without limbs"


class Outcome(msgspec.Struct):
    """Outcome of a run.

    Args:
        frames: Frames processed.
        complete: Whether it came to its own end, instead of being stopped.
        errors: Errors of sources, in order.
        dead_sinks: Names of the sinks that failed, and of a snapshot that could not be written.
        none_followed: Whether performers came and none of them could be followed.
        abandoned: Whether the reader of a sink went away (a closed pipe).
    """

    frames: int = 0
    complete: bool = False
    errors: list[Exception] = msgspec.field(default_factory=list)
    dead_sinks: list[str] = msgspec.field(default_factory=list)
    none_followed: bool = False
    abandoned: bool = False


def in_words(error: Exception) -> str:
    """Return the message of an error, in one line, with its kind if it is no error of data or settings."""
    text = " ".join(str(error).split())
    return (
        text
        if isinstance(error, MossarError)
        else f"internal error, please report it: {type(error).__name__}: {text}"
    )
