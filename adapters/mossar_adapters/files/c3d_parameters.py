"""Header and parameters of a C3D file, in the byte orders of Intel, DEC and SGI machines."""

import struct
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_adapters.files.errors import FileError

BLOCK = 512  # bytes
KEY = 0x50
INTEL, DEC, SGI = 84, 85, 86
_MAX_PARAMETERS = 1 << 20  # bytes; the format allows 255 blocks, some writers take more

Value = list[str] | NDArray[np.float64]


class C3dHeader(msgspec.Struct, frozen=True):
    """The first block.

    Args:
        points: Points per frame.
        analog: Analogue values per frame.
        first_frame: Number of the first frame, from 1.
        last_frame: Number of the last frame.
        scale: Factor of integer coordinates; a negative one means that the data are floats.
        data_block: Number of the first block of data, from 1.
        rate: Frames per second.
    """

    points: int
    analog: int
    first_frame: int
    last_frame: int
    scale: float
    data_block: int
    rate: float


def floats(data: bytes, machine: int) -> NDArray[np.float64]:
    """Return the 4-byte floats of a machine.

    DEC's have the halves swapped and another exponent: a quarter of the IEEE value of the bits.
    """
    if machine == DEC:
        halves = np.frombuffer(data, "<u2").reshape(-1, 2)[:, ::-1]
        return np.ascontiguousarray(halves).view("<f4").reshape(-1).astype(np.float64) / 4
    return np.frombuffer(data, ">f4" if machine == SGI else "<f4").astype(np.float64)


def written_floats(values: ArrayLike, machine: int) -> bytes:
    """Return values as 4-byte floats of a machine; the inverse of `floats`."""
    if machine == DEC:
        halves = (np.asarray(values, "<f4") * np.float32(4)).view("<u2").reshape(-1, 2)[:, ::-1]
        return np.ascontiguousarray(halves).tobytes()
    return np.asarray(values, ">f4" if machine == SGI else "<f4").tobytes()


def integers(data: bytes, machine: int) -> NDArray[np.int16]:
    """Return the 2-byte integers of a machine."""
    return np.frombuffer(data, ">i2" if machine == SGI else "<i2").astype(np.int16)


def read_parameters(path: Path) -> tuple[C3dHeader, int, dict[str, Value]]:
    """Read header and parameters.

    Returns:
        The header, the machine, and the parameters as `GROUP:NAME`.

    Raises:
        FileError: If they are damaged.
    """
    header, machine, section = read_section(path)
    return header, machine, _parameters(section, machine)


def read_section(path: Path) -> tuple[C3dHeader, int, bytes]:
    """Read the header, whose machine wrote it, and the section of parameters.

    Raises:
        FileError: If they are damaged.
    """
    with path.open("rb") as file:
        first = file.read(BLOCK)
        if len(first) < BLOCK or first[1] != KEY or first[0] == 0:
            raise FileError(path, "this is no C3D file, or it is cut off in its header")
        file.seek((first[0] - 1) * BLOCK)
        section = file.read(_MAX_PARAMETERS)
    if len(section) < BLOCK or section[3] not in {INTEL, DEC, SGI}:
        raise FileError(path, "the parameters are not where the header says")
    machine = section[3]
    header = _header(first, machine)
    blocks = max(section[2], header.data_block - first[0])
    return header, machine, section[: blocks * BLOCK]


def _header(first: bytes, machine: int) -> C3dHeader:
    words = integers(first[:24], machine).astype(np.uint16)
    with np.errstate(all="ignore"):
        scale, rate = floats(first[12:16], machine)[0], floats(first[20:24], machine)[0]
    points, analog, start, end = (int(word) for word in words[1:5])
    return C3dHeader(points, analog, start, end, float(scale), int(words[8]), float(rate))


class Record(msgspec.Struct, frozen=True):
    """A group or a parameter in the section.

    Args:
        begin: Byte of the section where it begins.
        value: Byte behind its name and the distance to the next record.
        step: That distance, from where it stands; 0 or less ends the list.
        group: Number of the group; negative for the record of the group itself.
        name: In upper case.
    """

    begin: int
    value: int
    step: int
    group: int
    name: str


def records(section: bytes, machine: int) -> Iterator[Record]:
    """Yield groups and parameters up to the end of the list or the first damaged one."""
    order = ">h" if machine == SGI else "<h"
    at = 4
    while at + 5 < len(section):
        name_length, group = struct.unpack_from("bb", section, at)
        if name_length == 0 or group == 0:
            break
        name_end = at + 2 + abs(name_length)
        if name_end + 3 > len(section):
            break
        name = text_of(section[at + 2 : name_end]).strip().upper()
        (step,) = struct.unpack_from(order, section, name_end)
        yield Record(at, name_end + 2, step, group, name)
        if step <= 0:
            break
        at = name_end + step


def text_of(data: bytes) -> str:
    """Return text that programs write in UTF-8 or, older ones, in Latin 1."""
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _parameters(section: bytes, machine: int) -> dict[str, Value]:
    """Return the parameters by `GROUP:NAME`."""
    groups: dict[int, str] = {}
    found: list[tuple[int, str, Value]] = []
    for record in records(section, machine):
        if record.group < 0:
            groups[-record.group] = record.name
        elif (value := _value(section, record.value, machine)) is not None:
            found.append((record.group, record.name, value))
    return {f"{groups.get(group, '')}:{name}": value for group, name, value in found}


def _value(section: bytes, at: int, machine: int) -> Value | None:
    """Return a parameter's value, None if it does not lie within the section."""
    if at + 2 > len(section):
        return None
    (kind,) = struct.unpack_from("b", section, at)
    dimensions = section[at + 2 : at + 2 + section[at + 1]]
    start = at + 2 + len(dimensions)
    count = 1
    for dimension in dimensions:
        count *= dimension
    data = section[start : start + count * abs(kind)]
    if kind not in {-1, 1, 2, 4} or count > len(section) or len(data) < count * abs(kind):
        return None
    if kind == -1:
        width = dimensions[0] if dimensions else 1
        starts = range(0, len(data), width) if width else ()
        return [text_of(data[i : i + width]).strip(" \0") for i in starts]
    with np.errstate(all="ignore"):
        match kind:
            case 1:
                return np.frombuffer(data, np.uint8).astype(np.float64)
            case 2:
                return integers(data, machine).astype(np.float64)
            case _:
                return floats(data, machine)
