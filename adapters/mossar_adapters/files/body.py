"""The body in a recording: joints that are no part of it, and a size that no body has.

Many programs write a joint above the hips that stays at the origin of the world or follows the hips on the floor. Its motion
shows it, not its name. A size contradicts a unit when the body would be as small as a coin or as tall as a tower.
"""

import functools
from collections.abc import Collection, Iterator, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import METRES, ReadOptions
from mossar_adapters.files.selection import of_joints
from mossar_adapters.files.units import USUAL_HEIGHT, height
from mossar_adapters.source import Chunks, Meta, Recording
from mossar_stream import Frames, Skeleton, find_joints, narrow, read_joint_names

FAR = 0.75  # heights of the body: a joint so far from all others is no part of it, if its bone changes its length
FARTHER = 2.0  # heights: the same, even with a constant bone; a forearm is longer than the hand on it
CHANGE = 0.15  # heights by which the bone to a far joint changes its length at least
SWING = 0.25  # heights by which no bone changes its length
LONG = 0.35  # heights, from which on a bone between floor and hips may lead to a reference
BEYOND = 0.1  # heights that feet may be lower than the floor
STILL = 0.02  # heights that a joint moves which stands still
SWAY = 0.01  # heights that hips move at least
LEAST_BODY = 6  # joints
MOST_LOOKED_AT = 4000  # frames
_MAIN = 0.75  # share of the joints below a reference that hang on its one main child
_NO_PART = frozenset({"", "root"})  # parts of the body that a reference may be called like

Limits = tuple[float, float]
BODY: Limits = (0.4, 3.5)  # m, of a body whose head and legs are known by name
THINGS: Limits = (0.05, 12.0)  # m, of markers: a hand is less than a body, a crowd is more
ANYTHING: Limits = (0.0, float("inf"))  # of a few points, which are no body
PEOPLE: Limits = (0.9, 2.4)  # m, that a unit must lead to


def reference_joints(skeleton: Skeleton, positions: NDArray[Any], root: str | None = None) -> tuple[str, ...]:
    """Return the joints that are no part of the body: static or on the floor, far from all others, with one child.

    Args:
        skeleton: J joints.
        positions: (n, J, 3), any unit, NaN where a joint is missing.
        root: The joint that the user names as the centre: it and the joints below it belong to the body.
    """
    children = _children(skeleton)
    tops = [joint for joint, parent in enumerate(skeleton.parents) if parent < 0]
    body = _largest(tops, children)
    found: set[int] = set()
    for top in tops:
        if children[top]:
            found |= _above_the_body(skeleton, children, top, positions)
        elif 3 * len(body) >= 2 * len(skeleton):
            found |= _unmoved({top}, body, positions, must_be_far=True)
    if root is not None:
        found -= set(_below(skeleton.index(root), children))
    return tuple(skeleton.names[joint] for joint in sorted(found)) if len(found) < len(skeleton) else ()


def has_candidates(skeleton: Skeleton) -> bool:
    """Return whether a skeleton has a joint that may be no part of the body."""
    children = _children(skeleton)
    tops = [joint for joint, parent in enumerate(skeleton.parents) if parent < 0]
    lone = any(not children[top] for top in tops) and 3 * len(_largest(tops, children)) >= 2 * len(skeleton)
    return lone or any(_chain(children, top)[1] for top in tops)


def _children(skeleton: Skeleton) -> list[list[int]]:
    children: list[list[int]] = [[] for _ in skeleton.names]
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            children[parent].append(joint)
    return children


def _largest(tops: list[int], children: list[list[int]]) -> list[int]:
    """Return the joints of the largest tree; none if it is too small to be a body."""
    largest = max((_below(top, children) for top in tops), key=len)
    return largest if len(largest) >= LEAST_BODY else []


def _below(joint: int, children: list[list[int]]) -> list[int]:
    """Return a joint and all that hang on it."""
    order = [joint]
    for one in order:  # grows while it is read
        order += children[one]
    return order


def _above_the_body(
    skeleton: Skeleton, children: list[list[int]], top: int, positions: NDArray[Any]
) -> set[int]:
    """Return the joints from the top of a tree down to the last one outside its body, and the other joints on them."""
    chain, bodies = _chain(children, top)
    for level in range(len(bodies) - 1, -1, -1):
        joint, body = chain[level], bodies[level]
        if _is_reference(skeleton, children, joint, body, positions):
            beside = set(_below(top, children)) - set(body) - set(chain[: level + 1])
            return {*chain[: level + 1], *_unmoved(beside, body, positions)}
    return set()


def _chain(children: list[list[int]], top: int) -> tuple[list[int], list[list[int]]]:
    """Return a top and its main children, one below the other, and the children of each, the main one first."""
    chain, body = [top], _below(top, children)
    bodies: list[list[int]] = []
    while len(body) > LEAST_BODY:
        main = max((_below(child, children) for child in children[chain[-1]]), key=len)
        if len(main) < LEAST_BODY or len(main) < _MAIN * (len(body) - 1):
            break
        chain.append(main[0])
        bodies.append(main)
        body = main
    return chain, bodies


def _is_reference(
    skeleton: Skeleton, children: list[list[int]], joint: int, body: list[int], positions: NDArray[Any]
) -> bool:
    """Return whether a joint is not part of the body whose first joint hangs on it."""
    seen = np.isfinite(positions[:, [joint, body[0]]]).all(axis=(1, 2))
    frames = positions[seen].astype(np.float64)
    tall = height(frames[:, body]) if len(frames) else 0.0
    if tall <= 0:
        return False
    place, centre = frames[:, joint], frames[:, body[0]]
    bone = place - centre
    length = np.linalg.norm(bone, axis=1)
    apart = np.nanmin(np.linalg.norm(frames[:, body] - place[:, None], axis=2), axis=1)
    change, distance = _spread(length), float(np.median(apart))
    if change > SWING * tall or distance > FARTHER * tall:
        return True
    if distance > FAR * tall and (change > CHANGE * tall or _is_under_hips(skeleton, joint, body)):
        return True
    if np.median(length) < LONG * tall:
        return False
    along = bone / np.maximum(length, 1e-12)[:, None]
    reach = np.nanmax(np.einsum("nkd,nd->nk", frames[:, body] - centre[:, None], along), axis=1)
    if np.median(reach - length) > BEYOND * tall:
        return False
    return _is_under_hips(skeleton, joint, body) or (
        len(children[joint]) == 1 and _is_on_the_floor(place, centre, tall)
    )


def _is_under_hips(skeleton: Skeleton, joint: int, body: Sequence[int]) -> bool:
    """Return whether a child of a joint is named like hips, and the joint itself not like a part of a body."""
    part = read_joint_names(skeleton.names)[joint].part
    names = [skeleton.names[member] for member in body]
    return part in _NO_PART and find_joints(names).get("hips") == 0


def _is_on_the_floor(place: NDArray[np.float64], centre: NDArray[np.float64], tall: float) -> bool:
    """Return whether a joint stands still, or moves on a plane, while the joint that hangs on it does not."""
    own = np.array([_spread(place[:, d]) for d in range(3)])
    others = np.array([_spread(centre[:, d]) for d in range(3)])
    stands = own.max() <= STILL * tall and others.max() > 3 * own.max() + SWAY * tall
    slides = (own <= 0.25 * STILL * tall) & (others > STILL * tall)
    return bool(stands or slides.any())


def _unmoved(
    joints: Collection[int], body: list[int], positions: NDArray[Any], *, must_be_far: bool = False
) -> set[int]:
    """Return those joints that stand still or are far from a body."""
    found: set[int] = set()
    tall = height(positions[:, body]) if body and joints else 0.0
    if tall <= 0:
        return found
    for joint in joints:
        frames = positions[np.isfinite(positions[:, joint]).all(axis=1)].astype(np.float64)
        frames = frames[np.isfinite(frames[:, body]).all(axis=2).any(axis=1)]
        if not len(frames):
            continue
        place = frames[:, joint]
        still = max(_spread(place[:, d]) for d in range(3)) <= STILL * tall
        apart = np.nanmin(np.linalg.norm(frames[:, body] - place[:, None], axis=2), axis=1)
        far = float(np.percentile(apart, 90)) > FAR * tall
        if (still and far) or (not must_be_far and (still or far)):
            found.add(joint)
    return found


def _spread(values: NDArray[np.float64]) -> float:
    low, high = np.percentile(values, [5, 95])
    return float(high - low)


def body_height(skeleton: Skeleton, positions: NDArray[Any], root: str | None = None) -> float:
    """Return the height of a body, without the joints that are no part of it; see `height`."""
    joints = body_joints(skeleton, reference_joints(skeleton, positions, root))
    return height(positions[:, joints] if len(joints) else positions)


def first_frames(recording: Recording) -> NDArray[Any]:
    """Return (n, J, 3) frames of the first performer from the beginning of a recording: more where a joint is to be judged."""
    wanted = MOST_LOOKED_AT if has_candidates(recording.skeleton) else 1
    found: list[NDArray[Any]] = [np.zeros((0, len(recording.skeleton), 3), np.float32)]
    for frames in recording.chunks():
        if frames.performer == recording.performers[0]:
            found.append(frames.positions)
        if sum(map(len, found)) >= wanted:
            break
    return np.concatenate(found)


def checked(recording: Recording, options: ReadOptions) -> Recording:
    """Return a recording in a unit that fits the body, with the joints that are no part of it named.

    Args:
        recording: In metres, by the reader's unit.
        options: The user's unit and centre take precedence.
    """
    shown = first_frames(recording)
    reference: tuple[str, ...] = ()
    if has_candidates(recording.skeleton):
        root = options.root if options.root in recording.skeleton.names else None
        reference = reference_joints(recording.skeleton, shown, root)
    joints = body_joints(recording.skeleton, reference)
    tall = height(shown[:, joints] if len(joints) else shown)
    names = body_skeleton(recording.skeleton, reference).names
    factor = fitting_factor(tall, limits_of(names), recording.metres)
    given = options.unit != "auto"
    notes = [size_note(tall, factor, recording.metres, given=given)]
    if reference:
        notes.append(reference_note(reference))
    chunks = recording.chunks
    if factor not in (None, 1.0) and not given:
        chunks = functools.partial(_multiplied, recording.chunks, factor)
    return msgspec.structs.replace(
        recording,
        skeleton=body_root(recording.skeleton, reference),
        chunks=chunks,
        metres=recording.metres if factor is None or given else recording.metres * factor,
        notes=(*recording.notes, *filter(None, notes)),
        reference=reference,
    )


def _multiplied(chunks: Chunks, factor: float) -> Iterator[Frames]:
    return (multiplied(frames, factor) for frames in chunks())


def multiplied(frames: Frames, factor: float) -> Frames:
    """Return frames whose positions are so many times as large."""
    larger = narrow(frames.positions.astype(np.float64) * factor)
    return msgspec.structs.replace(frames, positions=larger)


def limits_of(names: Sequence[str]) -> Limits:
    """Return the least and the largest height of a body with these joints, m."""
    if len(names) < LEAST_BODY:
        return ANYTHING
    known = find_joints(names).keys()
    parts = {slot.rpartition("_")[2] for slot in known}
    is_whole = bool(parts & {"knee", "ankle", "foot"}) and bool(parts & {"head", "neck", "shoulder"})
    return BODY if len(known) >= 8 and is_whole else THINGS


def fitting_factor(tall: float, limits: Limits, stated: float = 1.0) -> float | None:
    """Return the factor that brings a height within limits: 1 where it fits, None where no metric unit does.

    Args:
        tall: m, in the unit that was stated.
        limits: See `limits_of`.
        stated: m, that unit.

    Example:
        >>> fitting_factor(0.0017, BODY, 0.001), fitting_factor(1.7, BODY), fitting_factor(0.02, BODY)
        (1000.0, 1.0, None)
    """
    if tall <= 0 or limits[0] <= tall <= limits[1]:
        return 1.0
    fitting = [
        factor for factor in (unit / stated for unit in _METRIC) if PEOPLE[0] <= tall * factor <= PEOPLE[1]
    ]
    return min(fitting, key=lambda factor: abs(np.log(tall * factor / USUAL_HEIGHT)), default=None)


_METRIC = (1.0, 0.01, 0.001)


def size_in_words(tall: float) -> str:
    """Return a height as readable text.

    Example:
        >>> [size_in_words(tall) for tall in (0.00171, 0.021, 1.7, 1700.0)]
        ['1.7 mm', '2.1 cm', '1.7 m', '1700 m']
    """
    unit = "mm" if tall < 0.01 else "cm" if tall < 0.5 else "m"
    size = tall / METRES[unit]
    return f"{size:.0f} {unit}" if size >= 10 else f"{size:.1f}".removesuffix(".0") + f" {unit}"


def size_note(tall: float, factor: float | None, stated: float, *, given: bool) -> str | None:
    """Return a note about a body's height, None if it fits.

    Args:
        tall: m, in the unit that was stated.
        factor: See `fitting_factor`.
        stated: m, that unit.
        given: Whether the user gave the unit.
    """
    if factor == 1.0:
        return None
    if factor is None or given:
        return f"the body is {size_in_words(tall)} tall; {'check' if given else 'set'} --unit"
    metres = stated * factor
    unit = next((name for name, own in METRES.items() if abs(own / metres - 1) < 1e-6), f"{metres:g} m")
    return (
        f"the stated unit makes the body {size_in_words(tall)} tall: unit taken as {unit} "
        f"({size_in_words(tall * factor)} tall); set --unit to change"
    )


def reference_note(reference: Sequence[str]) -> str:
    """Return a note about joints that are left out."""
    names = ", ".join(reference[:8])
    are = "are no parts" if len(reference) > 1 else "is no part"
    return f"{names} {are} of the body (far from it, or on the floor) and left out; --root {reference[0]} keeps {reference[0]}"


def body_root(skeleton: Skeleton, reference: Sequence[str]) -> Skeleton:
    """Return a skeleton whose centre is a joint of the body: the first one below joints that are no part of it."""
    if skeleton.root < 0 or skeleton.names[skeleton.root] not in reference:
        return skeleton
    kept = tuple(name for name in skeleton.names if name not in reference)
    body = skeleton.select(kept)
    tops = [joint for joint, parent in enumerate(body.parents) if parent < 0]
    sizes = {top: sum(_top_of(body, joint) == top for joint in range(len(body))) for top in tops}
    return skeleton.with_root(body.names[max(tops, key=sizes.__getitem__)])


def _top_of(skeleton: Skeleton, joint: int) -> int:
    while skeleton.parents[joint] >= 0:
        joint = skeleton.parents[joint]
    return joint


def body_joints(skeleton: Skeleton, reference: Sequence[str]) -> NDArray[np.intp]:
    """Return the joints of the body; none if all are."""
    if not reference:
        return np.zeros(0, np.intp)
    return np.array([j for j, name in enumerate(skeleton.names) if name not in reference], np.intp)


def body_skeleton(skeleton: Skeleton, reference: Sequence[str]) -> Skeleton:
    """Return the skeleton of the body."""
    if not reference:
        return skeleton
    return skeleton.select(tuple(name for name in skeleton.names if name not in reference))


def body_meta(meta: Meta) -> Meta:
    """Return a meta without the joints that are no part of the body."""
    if not meta.reference:
        return meta
    return msgspec.structs.replace(meta, skeleton=body_skeleton(meta.skeleton, meta.reference), reference=())


def body_recording(recording: Recording) -> Recording:
    """Return a recording without the joints that are no part of the body."""
    if not recording.reference:
        return recording
    joints = body_joints(recording.skeleton, recording.reference)
    return msgspec.structs.replace(
        recording,
        skeleton=body_skeleton(recording.skeleton, recording.reference),
        chunks=lambda: (of_joints(frames, joints) for frames in recording.chunks()),
        reference=(),
    )
