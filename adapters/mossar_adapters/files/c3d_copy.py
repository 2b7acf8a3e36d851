"""Copies of C3D files: changes are written anew, every other byte of header, parameters and data stays.

Programs that read a C3D file and write it again change it: parameters that they do not know, the kind of numbers, the
padding. A copy made here differs from its source in the records that are replaced, and where the data begin if the
parameters no longer fit into their blocks.
"""

import math
import shutil
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import BinaryIO, Self

import msgspec

from mossar_adapters.files.c3d_parameters import (
    BLOCK,
    SGI,
    Record,
    read_section,
    records,
    written_floats,
)
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.output import OutputError
from mossar_adapters.files.replacing import Draft

MOST_BLOCKS = 255  # of parameters: their number is one byte
MOST = 255  # elements of a dimension: a byte, too
MOST_WORD = 65535
# Bytes of the header: where the data begin; the numbers of the first and last frame.
_START_WORD, _RANGE_WORDS = (
    16,
    6,
)
_STEP = 2  # bytes of the distance to the next record


class Parameter(msgspec.Struct, frozen=True):
    """A parameter to be written.

    Args:
        name: In upper case.
        kind: -1 text, 1 bytes, 2 integers, 4 floats.
        dimensions: The fastest first; empty for one number.
        data: Its bytes, in the machine's order.
    """

    name: str
    kind: int
    dimensions: tuple[int, ...]
    data: bytes


def texts(name: str, values: Sequence[str]) -> Parameter:
    """Return a parameter that holds a list of texts, in UTF-8, filled with spaces."""
    coded = [_shortened(value.encode()) for value in values]
    width = max([1, *map(len, coded)])
    return Parameter(name, -1, (width, len(coded)), b"".join(value.ljust(width) for value in coded))


def _shortened(text: bytes) -> bytes:
    """Return at most as many bytes as a dimension counts, and no part of a character."""
    return text if len(text) <= MOST else text[:MOST].decode(errors="ignore").encode()


def words(name: str, values: Sequence[int], machine: int, *, single: bool = False) -> Parameter:
    """Return a parameter of 2-byte integers: a list, or one number."""
    data = b"".join(_word(value, machine) for value in values)
    return Parameter(name, 2, () if single else (len(values),), data)


def numbers(name: str, values: Sequence[Sequence[float]], machine: int) -> Parameter:
    """Return a parameter of 4-byte floats with rows of the same length."""
    flat = [value for row in values for value in row]
    return Parameter(name, 4, (len(values[0]) if values else 0, len(values)), written_floats(flat, machine))


class C3dCopy:
    """A C3D file whose parameters are changed in memory, to be written elsewhere.

    Args:
        path: The source.

    Raises:
        FileError: If it is damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.header, self.machine, section = read_section(path)
        with path.open("rb") as file:
            self._first = bytearray(file.read(BLOCK))
        self._place = self._first[0] - 1  # block of the parameters, from 0
        before_data = self.header.data_block - 1 - self._place
        self._blocks = before_data if before_data > 0 else -(-len(section) // BLOCK)
        # Bytes: where data begin, those that are kept, how many.
        self._kept: tuple[int, int, int] | None = None
        self._head = bytearray(section[:4])
        self._groups: dict[str, int] = {}
        self._records: list[tuple[Record, bytearray]] = []
        for record in records(section, self.machine):
            end = record.value - _STEP + record.step if record.step > 0 else _end_of(section, record)
            self._records.append((record, bytearray(section[record.begin : end])))
            if record.group < 0:
                self._groups[record.name] = -record.group
        if not self._records:
            raise FileError(path, "there are no parameters in the file")

    def replace(self, group: str, parameters: Sequence[Parameter]) -> Self:
        """Put parameters into a group, in place of those of the same names; the group is made if there is none.

        Raises:
            FileError: If there are too many groups.
        """
        number = self._groups.get(group)
        if number is None:
            number = next((n for n in range(1, 128) if n not in self._groups.values()), None)
            if number is None:
                raise FileError(
                    self.path, f"there are 127 groups of parameters; there is no room for {group}"
                )
            self._groups[group] = number
            self._append(-number, group, b"\0")
        new = {parameter.name for parameter in parameters}
        self._records = [(r, d) for r, d in self._records if not (r.group == number and r.name in new)]
        for one in parameters:
            shape = bytes([one.kind & 255, len(one.dimensions), *one.dimensions])
            self._append(number, one.name, shape + one.data + b"\0")
        return self

    def remove(self, group: str, names: Sequence[str]) -> Self:
        """Take parameters out of a group."""
        number = self._groups.get(group)
        self._records = [(r, d) for r, d in self._records if not (r.group == number and r.name in names)]
        return self

    def set_words(self, values: Mapping[str, Sequence[int]]) -> Self:
        """Overwrite 2-byte integers where they stand; parameters that are missing, or of another kind, are passed over."""
        names = {number: group for group, number in self._groups.items()}
        for record, data in self._records:
            new = values.get(f"{names.get(record.group, '')}:{record.name}")
            at = record.value - record.begin
            if new is None or record.group < 0 or data[at] != 2:
                continue
            begin = at + 2 + data[at + 1]
            for i, value in enumerate(new):
                if begin + 2 * i + 2 <= len(data):
                    data[begin + 2 * i : begin + 2 * i + 2] = _word(value, self.machine)
        return self

    def set_range(self, first: int, last: int) -> Self:
        """Write numbers of the first and last frame, from 1, into the header."""
        pair = _word(min(first, MOST_WORD), self.machine) + _word(min(last, MOST_WORD), self.machine)
        self._first[_RANGE_WORDS : _RANGE_WORDS + 4] = pair
        return self

    def keep(self, start: int, begin: int, size: int) -> Self:
        """Copy only a part of the data.

        Args:
            start: Byte where the data begin.
            begin: Byte where the part begins.
            size: Its bytes.

        Raises:
            FileError: If the data do not lie behind the parameters.
        """
        if start < (self._place + self._blocks) * BLOCK:
            raise FileError(
                self.path, "the parameters lie behind the data; such a file is not cut into parts"
            )
        self._kept = start, begin, size
        return self

    def write(self, target: Path) -> None:
        """Write the file, all or nothing.

        Raises:
            FileError: If the parameters have no room.
            OutputError: If it cannot be written.
        """
        section = self._section()
        behind = (self._place + self._blocks) * BLOCK
        try:
            with Draft(target) as draft, self.path.open("rb") as source, draft.path.open("wb") as file:
                file.write(self._first)
                source.seek(BLOCK)
                file.write(source.read(max(0, self._place * BLOCK - BLOCK)))
                file.write(section)
                source.seek(behind)
                if self._kept is None:
                    shutil.copyfileobj(source, file)
                else:
                    start, begin, size = self._kept
                    file.write(source.read(start - behind))
                    _copy(source, begin, size, file)
                    file.write(b"\0" * (-file.tell() % BLOCK))
        except OSError as error:
            raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from None

    def _section(self) -> bytes:
        """Return the section of parameters, and make the data begin behind it."""
        needed = -(-(4 + sum(len(data) for _, data in self._records) + 2) // BLOCK)  # two zeros end the list
        blocks = max(self._blocks, needed)
        moved, start = blocks - self._blocks, self.header.data_block
        if moved and (blocks > MOST_BLOCKS or start + moved > MOST_WORD):
            raise FileError(
                self.path, f"the parameters would need {blocks} blocks; a C3D file has at most {MOST_BLOCKS}"
            )
        if moved and start > self._place + self._blocks:
            self._first[_START_WORD : _START_WORD + 2] = _word(start + moved, self.machine)
            self.set_words({"POINT:DATA_START": [start + moved]})
        if moved:
            self._head[2] = blocks
        content = b"".join(_linked(record, data, self.machine) for record, data in self._records)
        return (bytes(self._head) + content).ljust(blocks * BLOCK, b"\0")

    def _append(self, group: int, name: str, content: bytes) -> None:
        coded = name.encode()
        data = bytearray(struct.pack("bb", len(coded), group) + coded + b"\0\0" + content)
        self._records.append((Record(0, len(data) - len(content), 1, group, name), data))


def _linked(record: Record, data: bytearray, machine: int) -> bytes:
    """Return the bytes of a record with the distance to the next one."""
    at = record.value - record.begin - _STEP
    data[at : at + _STEP] = _word(len(data) - at, machine)
    return bytes(data)


def _end_of(section: bytes, record: Record) -> int:
    """Return the end of the last record, which does not state it."""
    at = record.value
    if record.group < 0:
        return at + 1 + section[at]
    rank = section[at + 1]
    kind: int = struct.unpack_from("b", section, at)[0]
    size = math.prod(section[at + 2 : at + 2 + rank]) * abs(kind)
    end = at + 2 + rank + size
    return min(len(section), end + 1 + (section[end] if end < len(section) else 0))


def _copy(source: BinaryIO, begin: int, size: int, target: BinaryIO) -> None:
    source.seek(begin)
    left = size
    while left > 0 and (part := source.read(min(left, 1 << 20))):
        target.write(part)
        left -= len(part)


def _word(value: int, machine: int) -> bytes:
    return struct.pack(">H" if machine == SGI else "<H", value & MOST_WORD)
