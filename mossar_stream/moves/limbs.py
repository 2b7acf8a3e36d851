"""Limbs: groups of joints, by the names of known joint sets or else by the hierarchy."""

from mossar_stream.events import BODY
from mossar_stream.moves.joints import ENOUGH_NAMES, known_joints
from mossar_stream.settings.limb_groups import MOST_LIMBS
from mossar_stream.skeleton import Skeleton

TRUNK = "trunk"
LEAST_LIMB = 3  # joints, one below the other, of a limb that branches off
_PARTS = {"shoulder": "arm", "elbow": "arm", "wrist": "arm", "hand": "arm"} | dict.fromkeys(
    ("hip", "knee", "ankle", "foot"), "leg"
)


def limbs_of(skeleton: Skeleton) -> dict[str, tuple[int, ...]]:
    """Return the joints of each limb of a skeleton.

    Known names give the trunk with the head, left and right arm, left and right leg. Otherwise the hierarchy decides: the
    branches from the root are limbs, called like their first joint ("body_limb" for `body`, the channel of the body). A
    stem with limbs on it, such as a spine with arms, is the trunk.

    Args:
        skeleton: Of the performer.

    Returns:
        Name of a limb to indices of its joints; each joint is in at most one.

    Example:
        >>> limbs_of(Skeleton(("hip", "rod", "tip", "wheel"), (-1, 0, 1, 0)))
        {'rod': (1, 2), 'wheel': (3,)}
    """
    known = known_joints(skeleton)
    if not limbs_are_guessed(skeleton):
        return _named(skeleton, known)
    return _by_hierarchy(skeleton)


def limbs_are_guessed(skeleton: Skeleton) -> bool:
    """Return whether limbs follow from the hierarchy, because too few joints are known by name.

    Example:
        >>> limbs_are_guessed(Skeleton(("hip", "rod", "tip", "wheel"), (-1, 0, 1, 0)))
        True
    """
    return len(known_joints(skeleton)) < ENOUGH_NAMES


def limb_of_slot(slot: str) -> str:
    """Return the limb of a known joint, such as `left_arm` for "left_wrist"."""
    side, _, part = slot.partition("_")
    return f"{side}_{_PARTS[part]}" if part in _PARTS else TRUNK


def _named(skeleton: Skeleton, known: dict[str, int]) -> dict[str, tuple[int, ...]]:
    limb = {joint: limb_of_slot(slot) for slot, joint in known.items()}
    for joint in range(len(skeleton)):  # thumbs and toes go with the joint that they hang on
        ancestor = joint
        while ancestor >= 0 and ancestor not in limb:
            ancestor = skeleton.parents[ancestor]
        limb.setdefault(joint, limb.get(ancestor, TRUNK))
    order = (TRUNK, "left_arm", "right_arm", "left_leg", "right_leg")
    members = {name: tuple(j for j in range(len(skeleton)) if limb[j] == name) for name in order}
    return {name: joints for name, joints in members.items() if joints}


def _by_hierarchy(skeleton: Skeleton) -> dict[str, tuple[int, ...]]:
    children: list[list[int]] = [[] for _ in skeleton.names]
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            children[parent].append(joint)
    root = max(skeleton.root, 0)
    shapes, depths = _shapes(children)
    of_root = [shapes[child] for child in children[root]]
    tops, trunk = [], []
    for child in children[root]:
        is_single = of_root.count(shapes[child]) == 1  # unlike legs, of which there are two
        stem = _stem(child, children, depths) if is_single else []
        tops += children[stem[-1]] if stem else [child]
        trunk += stem
    tops = tops[: MOST_LIMBS - bool(trunk)]
    below = _below(skeleton, tops)
    named = {skeleton.names[top]: below[top] for top in tops}
    found = {f"{name}_limb" if name == BODY else name: joints for name, joints in named.items()}
    if trunk and found:
        found.pop(TRUNK, None)
        found = {TRUNK: tuple(sorted([root, *trunk])), **found}
    return found or {TRUNK: tuple(range(len(skeleton)))}


def _shapes(children: list[list[int]]) -> tuple[list[int], list[int]]:
    """Return a number for the shape of the joints below each joint, and the length of the longest chain of joints there."""
    hanging = {child for own in children for child in own}
    order = [joint for joint in range(len(children)) if joint not in hanging]
    for joint in order:  # grows while it is read
        order += children[joint]
    numbers: dict[tuple[int, ...], int] = {}
    shapes, depths = [0] * len(children), [1] * len(children)
    for joint in reversed(order):
        own = children[joint]
        shapes[joint] = numbers.setdefault(tuple(sorted(shapes[child] for child in own)), len(numbers))
        depths[joint] = 1 + max((depths[child] for child in own), default=0)
    return shapes, depths


def _stem(joint: int, children: list[list[int]], depths: list[int]) -> list[int]:
    """Return the joints from one up to the branch of limbs of several joints; none if that is no stem."""
    stem = [joint]
    while len(children[stem[-1]]) == 1:
        stem.append(children[stem[-1]][0])
    long = [child for child in children[stem[-1]] if depths[child] >= LEAST_LIMB]
    return stem if len(long) >= 2 else []


def _below(skeleton: Skeleton, tops: list[int]) -> dict[int, tuple[int, ...]]:
    """Return each of some joints, none below another, with all joints below it."""
    top_of = {-1: -1} | {top: top for top in tops}  # -1: it hangs on none of them
    found: dict[int, list[int]] = {top: [] for top in [*tops, -1]}
    for joint in range(len(skeleton)):
        way, ancestor = [], joint
        while ancestor not in top_of:
            way.append(ancestor)
            ancestor = skeleton.parents[ancestor]
        top_of |= dict.fromkeys(way, top_of[ancestor])
        found[top_of[joint]].append(joint)
    return {top: tuple(found[top]) for top in tops}
