"""Skeleton: the names of the joints, and their parents."""

import difflib
import operator
from collections.abc import Iterable

import msgspec

from mossar_stream.errors import FrameError

MAX_JOINTS = 1024
MAX_NAME = 128


class Skeleton(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Joints of a performer, in the order in which positions carry them.

    Args:
        names: One name per joint, unique. Lists and arrays of names are taken, too.
        parents: Index of each joint's parent; -1 for a joint without one. Empty means no joint has a parent.
        root: Index of the body centre, or -1 if there is none (unnamed markers): then the centroid of the
            joints is the centre (paper 3.1.1, localisation).

    Raises:
        FrameError: If the lengths differ, names repeat or are empty, a parent is out of range, the parents form a
            cycle, or there are more than `MAX_JOINTS` joints.
        TypeError: If names are no texts, or parents or the root no whole numbers.

    Example:
        >>> Skeleton(("hip", "knee", "foot"), (-1, 0, 1)).index("foot")
        2
    """

    names: tuple[str, ...]
    parents: tuple[int, ...] = ()
    root: int = 0

    def __post_init__(self) -> None:
        for field, value in zip(
            self.__struct_fields__, _plain(self.names, self.parents, self.root), strict=True
        ):
            msgspec.structs.force_setattr(self, field, value)
        count = len(self.names)
        if not 1 <= count <= MAX_JOINTS:
            raise FrameError(f"a skeleton has 1 to {MAX_JOINTS} joints, not {count}")
        if not self.parents:
            msgspec.structs.force_setattr(self, "parents", (-1,) * count)
        if len(self.parents) != count:
            raise FrameError(f"{count} joint names but {len(self.parents)} parents")
        if not -1 <= self.root < count:
            raise FrameError(f"root {self.root} is not one of {count} joints")
        _check_names(self.names)
        _check_parents(self.parents)

    def __len__(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """Return the index of the joint called `name`.

        Raises:
            FrameError: If there is no such joint.
        """
        try:
            return self.names.index(name)
        except ValueError:
            near = difflib.get_close_matches(str(name), self.names, 1)
            hint = f" - did you mean {near[0]}?" if near else ""
            raise FrameError(
                f"no joint called {name!r}; there are {', '.join(self.names[:40])}{hint}"
            ) from None

    def with_root(self, name: str) -> "Skeleton":
        """Return the same joints with another body centre."""
        return Skeleton(self.names, self.parents, self.index(name))

    def select(self, names: tuple[str, ...]) -> "Skeleton":
        """Return the skeleton of the named joints only, in the given order.

        A joint's parent becomes its nearest selected ancestor. The root stays if it is selected; otherwise
        the first joint without a parent is the root.

        Args:
            names: Joints to keep.

        Raises:
            FrameError: If a name is unknown or given twice, or there is none.
        """
        if not names:
            raise FrameError("a skeleton has at least one joint; none was selected")
        kept = [self.index(name) for name in names]
        place = {joint: i for i, joint in enumerate(kept)}
        parents = []
        for joint in kept:
            ancestor = self.parents[joint]
            while ancestor >= 0 and ancestor not in place:
                ancestor = self.parents[ancestor]
            parents.append(place.get(ancestor, -1))
        root = place.get(self.root, -1 if self.root < 0 else parents.index(-1))
        return Skeleton(tuple(names), tuple(parents), root)

    def bones(self) -> list[tuple[int, int]]:
        """Return the (parent, child) index pairs of all bones."""
        return [(parent, child) for child, parent in enumerate(self.parents) if parent >= 0]


def _plain(
    names: Iterable[str], parents: Iterable[int], root: int
) -> tuple[tuple[str, ...], tuple[int, ...], int]:
    """Return the fields of a skeleton as plain texts and numbers: recordings have them as arrays."""
    if isinstance(names, str):
        raise TypeError(f"a skeleton needs the names of its joints, not one text, {names[:40]!r}")
    texts = tuple(names)
    if not all(isinstance(name, str) for name in texts):
        raise TypeError("the names of joints are texts")
    try:
        return tuple(map(str, texts)), tuple(map(operator.index, parents)), operator.index(root)
    except TypeError:
        raise TypeError("parents and the root of a skeleton are whole numbers") from None


def _check_names(names: tuple[str, ...]) -> None:
    seen: set[str] = set()
    for name in names:
        if not name or len(name) > MAX_NAME:
            raise FrameError(f"joint names have 1 to {MAX_NAME} characters, not {name[:40]!r}")
        if name in seen:
            raise FrameError(f"two joints are called {name!r}")
        seen.add(name)


def _check_parents(parents: tuple[int, ...]) -> None:
    count = len(parents)
    for joint, parent in enumerate(parents):
        if not -1 <= parent < count:
            raise FrameError(f"parent {parent} of joint {joint} is not one of {count} joints")
    rooted = {-1}  # joints whose ancestors are known to end
    for joint in range(count):
        way: set[int] = set()
        ancestor = joint
        while ancestor not in rooted:
            if ancestor in way:
                raise FrameError(f"the parents of joint {joint} form a cycle")
            way.add(ancestor)
            ancestor = parents[ancestor]
        rooted |= way
