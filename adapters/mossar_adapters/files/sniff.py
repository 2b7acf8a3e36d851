"""What the formats look like at their beginning."""

import re
from collections.abc import Callable
from pathlib import Path

from mossar_adapters.files.text import head_text

Sniffer = Callable[[bytes, Path], bool]


def text(looks: Callable[[str], object]) -> Sniffer:
    """Return a sniffer for a format of text.

    Args:
        looks: Whether a file that begins with this text is of the format.
    """
    return lambda head, _path: bool(looks(head_text(head)))


def magic(*beginnings: bytes) -> Sniffer:
    """Return a sniffer for a format that begins with certain bytes."""
    return lambda head, _path: head.startswith(beginnings)


def bvh(head: str) -> bool:
    """Return whether this is BVH."""
    return head.lstrip()[:9].upper() == "HIERARCHY"


def amc(head: str) -> bool:
    """Return whether this is AMC: comments and keywords, then a frame number and bones."""
    return re.search(r"^\s*1?\d*\s*\n\s*[A-Za-z_]\w*(\s+[-+.\deE]+)+\s*$", head, re.MULTILINE) is not None


def json_lines(head: str) -> bool:
    """Return whether this is JSON with one object per line."""
    first, _, rest = head.lstrip().partition("\n")
    return first.startswith("{") and first.rstrip().endswith("}") and rest.lstrip()[:1] in {"{", ""}


def any_text(head: str) -> bool:
    """Return whether this is text at all."""
    return bool(head.strip())


def c3d(head: bytes, _path: Path) -> bool:
    """Return whether this is C3D."""
    return len(head) > 1 and head[1] == 0x50
