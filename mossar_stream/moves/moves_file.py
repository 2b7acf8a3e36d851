"""The form of moves as text: JSON with a version, checked before anything is believed.

    {"format": "mossar-moves", "version": 1, "skeleton": {"names": […], "parents": […], "root": 0},
     "examples": [{"name": "jab_left", "fps": 30.0, "positions": [-123, 4567, …]}, …]}

Positions are tenths of a millimetre, frame by frame, joint by joint.
"""

from collections.abc import Sequence
from typing import Annotated, Literal

import msgspec

from mossar_stream.errors import FrameError, MovesError
from mossar_stream.moves.example import LEAST_FRAMES, MAX_FRAMES, Example, check_name
from mossar_stream.skeleton import Skeleton

VERSION = 1
MAX_EXAMPLES = 500
MAX_BYTES = 64 << 20


class _Kind(msgspec.Struct, frozen=True):
    """What is looked at first."""

    format: Literal["mossar-moves"]
    version: Annotated[int, msgspec.Meta(ge=1)]


class _Content(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    format: Literal["mossar-moves"]
    version: Literal[1]
    skeleton: Skeleton
    examples: Annotated[list[Example], msgspec.Meta(max_length=MAX_EXAMPLES)]


def write_moves(skeleton: Skeleton, examples: Sequence[Example]) -> bytes:
    """Return examples as text, one example a line."""
    head = msgspec.json.encode(skeleton).decode()
    lines = ",\n".join(msgspec.json.encode(example).decode() for example in examples)
    return (
        f'{{"format":"mossar-moves","version":{VERSION},\n"skeleton":{head},\n"examples":[\n{lines}\n]}}\n'
    ).encode()


def read_moves(text: bytes) -> tuple[Skeleton, list[Example]]:
    """Return skeleton and examples of a text.

    Raises:
        MovesError: If it is not of that form, of a newer version, or too large.
    """
    if len(text) > MAX_BYTES:
        raise MovesError(f"a file of moves has at most {MAX_BYTES >> 20} megabytes")
    try:
        kind = msgspec.json.decode(text, type=_Kind)
        if kind.version > VERSION:
            raise MovesError(f"these moves have version {kind.version}; this program reads up to {VERSION}")
        content = msgspec.json.decode(text, type=_Content)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError, FrameError) as error:
        raise MovesError(f"this is not a file of moves: {error}") from None
    for place, example in enumerate(content.examples):
        _check(place, example, len(content.skeleton))
    return content.skeleton, content.examples


def _check(place: int, example: Example, joints: int) -> None:
    check_name(example.name)
    frames, rest = divmod(len(example.positions), 3 * joints)
    if rest or not LEAST_FRAMES <= frames <= MAX_FRAMES:
        raise MovesError(
            f"example {place} has {len(example.positions)} numbers, not {LEAST_FRAMES} to {MAX_FRAMES} frames"
            f" of {joints} joints"
        )
