"""The form of moves as text: JSON with a version, checked before any use.

    {"format": "mossar-moves", "version": 2, "skeleton": {"names": […], "parents": […], "root": 0},
     "facing": "any", "rules": {"jab_left": {"strict": 0.8, "again": 0.5, "mirrored": true}},
     "examples": [{"name": "jab_left", "fps": 30.0, "positions": [-123, 4567, …],
                   "whole_fps": 30.0, "whole": [-121, 4569, …]}, …]}

Positions are tenths of a millimetre, frame by frame, joint by joint. `facing` is "any" or "as_shown". Rules have the
values that differ from `MoveRule`'s defaults; moves without a rule need not be named, and poses may be mirrored. `whole` is the
whole recording, where `positions` are the movement alone; without it they are the same. Files of version 1 have none of these.

Files with held poses have version 3, and besides: "poses": [{"name": "plank", "positions": [-123, 4567, …], "hold": 2.0}, …],
with one frame each.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

import msgspec

from mossar_stream.errors import FrameError, MovesError
from mossar_stream.moves.example import LEAST_FRAMES, MAX_FRAMES, MOST_SHOWN, Example, check_name
from mossar_stream.moves.mirroring import mirrored_joints
from mossar_stream.moves.pose import Pose
from mossar_stream.moves.rules import MIRRORED, USUAL, Facing, MoveRule
from mossar_stream.skeleton import Skeleton

FILE_VERSION = 3
WITHOUT_POSES = 2  # version of files without held poses, which older programs read, too
MAX_EXAMPLES = 500
MAX_BYTES = 128 << 20


class _Kind(msgspec.Struct, frozen=True):
    """The part that is read first."""

    format: Literal["mossar-moves"]
    version: Annotated[int, msgspec.Meta(ge=1)]


class Content(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The content of a file of moves."""

    format: Literal["mossar-moves"]
    version: Literal[1, 2, 3]
    skeleton: Skeleton
    examples: Annotated[list[Example], msgspec.Meta(max_length=MAX_EXAMPLES)]
    facing: Facing = "any"
    rules: Annotated[dict[str, MoveRule], msgspec.Meta(max_length=MAX_EXAMPLES)] = {}
    poses: Annotated[list[Pose], msgspec.Meta(max_length=MAX_EXAMPLES)] = []


def write_moves(
    skeleton: Skeleton,
    examples: Sequence[Example],
    facing: Facing,
    rules: Mapping[str, MoveRule],
    poses: Sequence[Pose],
) -> bytes:
    """Return moves as text, one example or pose a line."""
    version = FILE_VERSION if poses else WITHOUT_POSES
    head, said = msgspec.json.encode(skeleton).decode(), msgspec.json.encode(rules).decode()
    lines = ",\n".join(msgspec.json.encode(example).decode() for example in examples)
    held = ",\n".join(msgspec.json.encode(pose).decode() for pose in poses)
    held = f',\n"poses":[\n{held}\n]' if poses else ""
    return (
        f'{{"format":"mossar-moves","version":{version},\n"skeleton":{head},\n"facing":"{facing}",\n"rules":{said},\n'
        f'"examples":[\n{lines}\n]{held}}}\n'
    ).encode()


def read_moves(text: bytes) -> Content:
    """Return the moves of a text.

    Raises:
        MovesError: If it is not of that form, of a newer version, or too large.
    """
    if len(text) > MAX_BYTES:
        raise MovesError(f"a file of moves has at most {MAX_BYTES >> 20} megabytes")
    try:
        kind = msgspec.json.decode(text, type=_Kind)
        if kind.version > FILE_VERSION:
            raise MovesError(
                f"these moves have version {kind.version}; this program reads up to {FILE_VERSION}"
            )
        content = msgspec.json.decode(text, type=Content)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError, FrameError) as error:
        raise MovesError(f"this is not a file of moves: {error}") from None
    for place, example in enumerate(content.examples):
        _check(place, example, len(content.skeleton))
    _check_rules(content)
    _check_poses(content)
    return content


def _check_poses(content: Content) -> None:
    joints = len(content.skeleton)
    moves = {example.name for example in content.examples}
    for place, pose in enumerate(content.poses):
        check_name(pose.name)
        if len(pose.positions) != 3 * joints:
            raise MovesError(
                f"pose {place} has {len(pose.positions)} numbers, not 3 for each of {joints} joints"
            )
        if pose.name in moves:
            raise MovesError(f"{pose.name!r} is a move and a pose; a name is one of them")


def _check_rules(content: Content) -> None:
    names = {example.name for example in content.examples}
    poses = {pose.name for pose in content.poses}
    for name, rule in content.rules.items():
        if name in poses and rule not in (USUAL, MIRRORED):
            raise MovesError(f"the rule for {name!r} is of a move; a pose can only be mirrored")
        if name not in names | poses:
            raise MovesError(f"there is a rule for {check_name(name)!r}, and no example of it")
        if rule.mirrored:
            mirrored_joints(content.skeleton)


def _check(place: int, example: Example, joints: int) -> None:
    check_name(example.name)
    frames, rest = divmod(len(example.positions), 3 * joints)
    if rest or not LEAST_FRAMES <= frames <= MAX_FRAMES:
        raise MovesError(
            f"example {place} has {len(example.positions)} numbers, not {LEAST_FRAMES} to {MAX_FRAMES} frames"
            f" of {joints} joints"
        )
    whole, rest = divmod(len(example.whole), 3 * joints)
    if rest or whole > MOST_SHOWN or bool(whole) != bool(example.whole_fps) or whole == 1:
        raise MovesError(
            f"example {place} has {len(example.whole)} numbers as its whole at {example.whole_fps:g} Hz, not 2 to {MOST_SHOWN}"
            f" frames of {joints} joints"
        )
