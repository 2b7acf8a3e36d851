"""The formats by their beginning."""

from collections.abc import Callable
from pathlib import Path

from mossar_adapters.files.cells import is_number
from mossar_adapters.files.osc_lines import log_message
from mossar_adapters.files.text import head_text

Sniffer = Callable[[bytes, Path], bool]

# How files begin that have to be unpacked or fetched, and how.
PACKED = {
    b"\x1f\x8b": "packed with gzip; unpack it first",
    b"BZh": "packed with bzip2; unpack it first",
    b"\xfd7zXZ": "packed with xz; unpack it first",
    b"7z\xbc\xaf": "packed with 7-Zip; unpack it first",
    b"version https://git-lfs": "a pointer of Git LFS, not the file itself; fetch that with git lfs pull",
    b"PK\x03\x04": "a zip archive or a workbook; unpack it, or save the sheet as CSV",
}


def text(looks: Callable[[str], object]) -> Sniffer:
    """Return a sniffer for a format of text.

    Args:
        looks: Whether a file that begins with this text is of the format.
    """
    return lambda head, _path: not head.startswith(tuple(PACKED)) and bool(looks(head_text(head)))


def magic(*beginnings: bytes) -> Sniffer:
    """Return a sniffer for a format that begins with certain bytes."""
    return lambda head, _path: head.startswith(beginnings)


def msk(head: bytes, _path: Path) -> bool:
    """Return whether this is our own format, in any version."""
    return head.startswith(b"MSK") and head[3:4].isdigit()


def bvh(head: str) -> bool:
    """Return whether this is BVH, below comments if there are some."""
    first = next((line for line in head.split("\n") if line.strip() and not line.startswith("#")), "")
    return first.replace("{", " ").upper().split()[:1] == ["HIERARCHY"]


def amc(head: str) -> bool:
    """Return whether this is AMC: after comments and keywords a frame number and a bone with its numbers."""
    lines = [line.split() for line in head.split("\n") if line and not line.isspace()]
    frames = [
        row for row, words in zip(lines[1:], lines, strict=False) if len(words) == 1 and words[0].isdecimal()
    ]
    return any(len(row) > 1 and not is_number(row[0]) and is_number(row[1]) for row in frames)


def json_lines(head: str) -> bool:
    """Return whether this is JSON with a meta or frame map per line."""
    first, _, rest = head.lstrip().partition("\n")
    one_line = first.startswith("{") and first.rstrip().endswith("}")
    return one_line and '"type"' in first and rest.lstrip()[:1] in {"{", ""}


def pose_json(head: bytes, path: Path) -> bool:
    """Return whether this is JSON, or a folder with some."""
    if path.is_dir():
        return any(entry.suffix.lower() == ".json" for entry in path.iterdir())
    return head_text(head).lstrip()[:1] in {"{", "["}


def video(head: bytes, _path: Path) -> bool:
    """Return whether this is a video: MP4 and MOV, AVI, WebM and Matroska."""
    boxes = {b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"}
    return head[4:8] in boxes or (head[:4], head[8:12]) == (b"RIFF", b"AVI ") or head[:4] == b"\x1aE\xdf\xa3"


def any_text(head: str) -> bool:
    """Return whether this is text at all."""
    return bool(head.strip())


def c3d(head: bytes, _path: Path) -> bool:
    """Return whether this is C3D."""
    return len(head) > 1 and head[1] == 0x50


def trc(head: str) -> bool:
    """Return whether this is TRC."""
    return head.lstrip().lower().startswith("pathfiletype")


def motive(head: str) -> bool:
    """Return whether this is Motive's CSV."""
    return head.lstrip().lstrip('"').lower().startswith("format version")


def qtm(head: str) -> bool:
    """Return whether this is QTM's export."""
    return any(line.upper().startswith("NO_OF_FRAMES") for line in head.lstrip().split("\n", 5)[:5])


def msrc12(head: str) -> bool:
    """Return whether the first line is 81 numbers."""
    words = head.lstrip().partition("\n")[0].replace(",", " ").split()
    return len(words) == 81 and words[0].isdecimal()


def ntu(head: str) -> bool:
    """Return whether the first two lines are counts."""
    first, second = (head.lstrip() + "\n").split("\n", 2)[:2]
    return all(line.strip().isdecimal() and len(line.strip()) < 10 for line in (first, second))


def osc_log(head: str) -> bool:
    """Return whether one of the first lines is an OSC message in text."""
    lines = [line for line in head.split("\n", 64)[:64] if line.strip()]
    return any(found is not None for found in map(log_message, lines))
