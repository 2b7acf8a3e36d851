"""ASF: the skeleton that belongs to an AMC recording."""

from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.kinematics import euler_rotations
from mossar_adapters.files.text import numbered_lines
from mossar_stream import MAX_JOINTS

INCH = 0.0254  # m; an ASF states its length as a share of an inch
_DOFS = {"rx", "ry", "rz", "tx", "ty", "tz", "l"}


class Bone(msgspec.Struct):
    """One bone, or the root, which has no length.

    Args:
        name: As written.
        vector: From its beginning to its end in world axes at rest, file units.
        axis: Angles of its own axes, in the file's angle unit, with `axis_order`.
        axis_order: Letters, first turn first.
        dofs: Its degrees of freedom in the motion, in order.
        parent: Index of the bone above.
    """

    name: str
    vector: NDArray[np.float64]
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    axis_order: str = "xyz"
    dofs: tuple[str, ...] = ()
    parent: int = -1


class Acclaim(msgspec.Struct, frozen=True):
    """A skeleton.

    Args:
        bones: The root first, then in file order.
        metres: Metres per unit of length as the file states it.
        degrees: Whether angles are in degrees.
    """

    bones: list[Bone]
    metres: float
    degrees: bool

    def own_axes(self) -> NDArray[np.float64]:
        """Return (B, 3, 3), the rotation C from the world's axes to those that a bone turns about."""
        unit = np.pi / 180 if self.degrees else 1.0
        return np.stack(
            [euler_rotations(np.array(bone.axis[::-1]) * unit, bone.axis_order[::-1]) for bone in self.bones]
        )


def skeleton_path(path: Path, given: str | None) -> Path:
    """Return the ASF for an AMC: given, same stem, stem before `_`, or the only one in the folder.

    Raises:
        FileError: If none or several come into question.
    """
    if given is not None:
        return Path(given)
    found = sorted(p for p in path.parent.iterdir() if p.suffix.lower() == ".asf")
    for stem in (path.stem, path.stem.split("_")[0]):
        for candidate in found:
            if candidate.stem.lower() == stem.lower():
                return candidate
    if len(found) == 1:
        return found[0]
    names = ", ".join(p.name for p in found[:8]) if found else "there is none in its folder"
    raise FileError(path, f"which .asf belongs to it? Say so with --skeleton FILE (candidates: {names})")


def read_skeleton(path: Path) -> Acclaim:
    """Read an ASF.

    Raises:
        FileError: If it is not one.
    """
    if not path.is_file():
        raise FileError(path, "there is no such skeleton file")
    sections = _sections(path)
    for name in ("root", "bonedata", "hierarchy"):
        if name not in sections:
            raise FileError(path, f"this is no ASF skeleton: the section :{name} is missing")
    length, degrees = _units(path, sections.get("units", []))
    bones = [_root(path, sections["root"]), *_bones(path, sections["bonedata"])]
    if len(bones) > MAX_JOINTS:
        raise FileError(path, f"the skeleton has more than {MAX_JOINTS} bones")
    _hang_together(path, bones, sections["hierarchy"])
    return Acclaim(bones, INCH / length, degrees)


def _sections(path: Path) -> dict[str, list[tuple[int, list[str]]]]:
    """Return the words of each line by section; words after a keyword belong to its section."""
    sections: dict[str, list[tuple[int, list[str]]]] = {}
    current: list[tuple[int, list[str]]] = []
    for line, text in numbered_lines(path):
        words = text.partition("#")[0].split()
        if words and words[0].startswith(":"):
            current = sections.setdefault(words[0][1:].lower(), [])
            words = words[1:]
        if words:
            current.append((line, words))
    return sections


def _units(path: Path, section: list[tuple[int, list[str]]]) -> tuple[float, bool]:
    length, degrees = 1.0, True
    for line, words in section:
        if words[0].lower() == "length":
            length = _numbers(path, line, words[1:2], 1)[0]
            if not 1e-6 < length < 1e6:
                raise FileError(path, f"a unit of length of {words[1]} is impossible", line)
        elif words[0].lower() == "angle":
            degrees = not words[-1].lower().startswith("rad")
    return length, degrees


def _root(path: Path, section: list[tuple[int, list[str]]]) -> Bone:
    root = Bone("root", np.zeros(3), dofs=("tx", "ty", "tz", "rx", "ry", "rz"))
    for line, words in section:
        match words[0].lower():
            case "order":
                root.dofs = _dofs(path, line, words[1:])
            case "axis":
                root.axis_order = _order(path, line, words[-1])
            case "orientation":
                root.axis = _numbers(path, line, words[1:], 3)
    return root


def _bones(path: Path, section: list[tuple[int, list[str]]]) -> Iterator[Bone]:
    bone, length, direction = Bone("", np.zeros(3)), 0.0, tuple[float, ...]()
    for line, words in section:
        match words[0].lower():
            case "begin":
                bone, length, direction = Bone("", np.zeros(3)), 0.0, ()
            case "name":
                bone.name = " ".join(words[1:])
            case "direction":
                direction = _numbers(path, line, words[1:], 3)
            case "length":
                length = _numbers(path, line, words[1:], 1)[0]
            case "axis":
                bone.axis = _numbers(path, line, words[1:4], 3)
                if len(words) > 4:
                    bone.axis_order = _order(path, line, words[4])
            case "dof":
                bone.dofs = _dofs(path, line, words[1:])
            case "end":
                if not bone.name or not direction:
                    raise FileError(path, "a bone without name or direction ends here", line)
                bone.vector = np.array(direction) * length
                yield bone


def _hang_together(path: Path, bones: list[Bone], section: list[tuple[int, list[str]]]) -> None:
    place = {bone.name: i for i, bone in enumerate(bones)}
    if len(place) < len(bones):
        raise FileError(path, "two bones have the same name")
    seen = {"root"}
    for line, words in section:
        if words[0].lower() in {"begin", "end"}:
            continue
        for name in words:
            if name not in place:
                raise FileError(path, f"there is no bone called {shown(name)}", line)
        for name in words[1:]:
            if words[0] not in seen or name in seen:
                raise FileError(
                    path, f"{shown(name)} hangs on a bone that is not on the root yet, or twice", line
                )
            seen.add(name)
            bones[place[name]].parent = place[words[0]]
    if len(seen) < len(bones):
        loose = next(bone.name for bone in bones if bone.name not in seen)
        raise FileError(path, f"the bone {shown(loose)} is not in the hierarchy")


def _numbers(path: Path, line: int, words: list[str], count: int) -> tuple[float, ...]:
    try:
        values = tuple(float(word) for word in words[:count])
    except ValueError:
        values = ()
    if len(values) != count or not all(abs(value) < 1e12 for value in values):
        raise FileError(path, f"{count} numbers are missing here", line)
    return values


def _order(path: Path, line: int, word: str) -> str:
    if sorted(word.lower()) != ["x", "y", "z"]:
        raise FileError(path, f"{shown(word)} is no order of axes", line)
    return word.lower()


def _dofs(path: Path, line: int, words: list[str]) -> tuple[str, ...]:
    dofs = tuple(word.lower() for word in words)
    if not set(dofs) <= _DOFS or len(set(dofs)) < len(dofs):
        raise FileError(path, f"{shown(' '.join(words))} are no degrees of freedom", line)
    return dofs
