"""The HIERARCHY part of a BVH file."""

import re
from collections.abc import Iterator
from pathlib import Path

import msgspec

from mossar_adapters.files.errors import FileError, shown
from mossar_stream import MAX_JOINTS

GLUED = re.compile(r"(?<=[0-9.])-")  # a minus sign that stands in for the blank before it
_OFFSET = re.compile(r"\bOFFSET-", re.IGNORECASE)
_CHANNELS = {f"{axis}{kind}" for axis in "xyz" for kind in ("position", "rotation")}


class BvhJoint(msgspec.Struct):
    """One joint of the hierarchy.

    Args:
        name: As written; end sites are called after their parent, `Head_End`.
        parent: Index of the joint above, -1 for a root.
        offset: Rest place in the parent's frame, file units.
        channels: Lower case, `xposition` … `zrotation`, in the order of the motion columns.
        first_channel: Column of its first channel.
    """

    name: str
    parent: int
    offset: tuple[float, ...] = (0.0, 0.0, 0.0)
    channels: tuple[str, ...] = ()
    first_channel: int = 0


class Hierarchy(msgspec.Struct, frozen=True):
    """All joints, parents before their children, and where the motion begins.

    Args:
        joints: In file order.
        width: Number of channels of all joints.
        motion_line: Number of the line MOTION.
    """

    joints: list[BvhJoint]
    width: int
    motion_line: int


def parse_hierarchy(path: Path, lines: Iterator[tuple[int, str]]) -> Hierarchy:
    """Read up to and including the line MOTION.

    Args:
        path: The file, for messages.
        lines: Numbered lines; those of the motion are left in it.

    Raises:
        FileError: If the hierarchy is not one.
    """
    joints: list[BvhJoint] = []
    open_joints: list[int] = []  # from the root to where we are
    last: int | None = None  # named but not opened yet
    width = line = 0
    for line, text in lines:
        if text.startswith("#"):
            continue
        words = _OFFSET.sub("OFFSET -", text.replace("{", " { ").replace("}", " } ")).split()
        while words:
            word = words.pop(0)
            match word.lower():
                case "root" | "joint" | "end":
                    last = len(joints)
                    joints.append(_named(joints, open_joints, word.lower(), words))
                    _check_count(path, line, joints)
                case "{" if last is not None:
                    open_joints.append(last)
                    last = None
                case "}" if open_joints:
                    open_joints.pop()
                case "offset" if open_joints:
                    joints[open_joints[-1]].offset = _offset(path, line, words)
                case "channels" if open_joints:
                    joint = joints[open_joints[-1]]
                    joint.channels, joint.first_channel = _channels(path, line, words), width
                    width += len(joint.channels)
                case "motion" if joints and not open_joints:
                    return Hierarchy(joints, width, line)
                case "hierarchy" if not joints:
                    pass
                case _:
                    raise FileError(path, f"{shown(word)} has no place here in a BVH hierarchy", line)
    raise FileError(path, "the file ends before the line MOTION", line or None)


def _named(joints: list[BvhJoint], open_joints: list[int], kind: str, words: list[str]) -> BvhJoint:
    name = []
    while words and words[0] != "{":
        name.append(words.pop(0))
    parent = open_joints[-1] if open_joints else -1
    if kind == "end":
        return BvhJoint(f"{joints[parent].name}_End" if joints else "End", parent)
    return BvhJoint(" ".join(name), parent)


def _check_count(path: Path, line: int, joints: list[BvhJoint]) -> None:
    if len(joints) > MAX_JOINTS:
        raise FileError(path, f"the hierarchy has more than {MAX_JOINTS} joints", line)


def _offset(path: Path, line: int, words: list[str]) -> tuple[float, ...]:
    if len(words) < 3 or any(GLUED.search(word) for word in words[:3]):
        words[:] = GLUED.sub(" -", " ".join(words)).split()
    try:
        offset = tuple(float(word.replace(",", ".")) for word in words[:3])
    except ValueError:
        raise FileError(path, "OFFSET is not followed by three numbers", line) from None
    if len(offset) != 3 or not all(abs(value) < 1e12 for value in offset):
        raise FileError(path, "OFFSET is not followed by three numbers", line)
    del words[:3]
    return offset


def _channels(path: Path, line: int, words: list[str]) -> tuple[str, ...]:
    count = int(words[0]) if words and words[0].isdecimal() and len(words[0]) < 3 else -1
    channels = tuple(word.lower() for word in words[1 : count + 1])
    if not 0 <= count == len(channels):
        raise FileError(path, "CHANNELS is not followed by a number and as many names", line)
    for channel in channels:
        if channel not in _CHANNELS:
            raise FileError(path, f"{shown(channel)} is not a BVH channel", line)
    if len(set(channels)) < count:
        raise FileError(path, "a channel is named twice", line)
    del words[: count + 1]
    return channels
