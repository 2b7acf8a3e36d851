"""Limbs: which joints belong together, by the names of known joint sets or else by the hierarchy."""

from mossar_stream.events import BODY
from mossar_stream.moves.joints import known_joints
from mossar_stream.settings.limb_groups import MOST_LIMBS
from mossar_stream.skeleton import Skeleton

TRUNK = "trunk"
_PARTS = {"shoulder": "arm", "elbow": "arm", "wrist": "arm", "hand": "arm"} | dict.fromkeys(
    ("hip", "knee", "ankle", "foot"), "leg"
)


def limbs_of(skeleton: Skeleton) -> dict[str, tuple[int, ...]]:
    """Return the joints of each limb of a skeleton.

    Trunk with head, left and right arm, left and right leg where the joints are known by name; otherwise what hangs on
    the root, one limb for each of its children, called like it ("body_limb" for `body`, the
    channel of the body).

    Args:
        skeleton: Of the performer.

    Returns:
        Name of a limb to indices of its joints; each joint is in at most one.

    Example:
        >>> limbs_of(Skeleton(("hip", "rod", "tip", "wheel"), (-1, 0, 1, 0)))
        {'rod': (1, 2), 'wheel': (3,)}
    """
    known = known_joints(skeleton)
    if len(known) >= 8:
        return _named(skeleton, known)
    children = [joint for joint, parent in enumerate(skeleton.parents) if parent == max(skeleton.root, 0)]
    names = {child: skeleton.names[child] for child in children[:MOST_LIMBS]}
    below = _below(skeleton, list(names))
    found = {f"{name}_limb" if name == BODY else name: below[child] for child, name in names.items()}
    return found or {TRUNK: tuple(range(len(skeleton)))}


def limb_of_slot(slot: str) -> str:
    """Return the limb of a known joint, such as `left_arm` for "left_wrist"."""
    side, _, part = slot.partition("_")
    return f"{side}_{_PARTS[part]}" if part in _PARTS else TRUNK


def _named(skeleton: Skeleton, known: dict[str, int]) -> dict[str, tuple[int, ...]]:
    limb = {joint: limb_of_slot(slot) for slot, joint in known.items()}
    for joint in range(len(skeleton)):  # thumbs and toes go with what they hang on
        ancestor = joint
        while ancestor >= 0 and ancestor not in limb:
            ancestor = skeleton.parents[ancestor]
        limb.setdefault(joint, limb.get(ancestor, TRUNK))
    order = (TRUNK, "left_arm", "right_arm", "left_leg", "right_leg")
    members = {name: tuple(j for j in range(len(skeleton)) if limb[j] == name) for name in order}
    return {name: joints for name, joints in members.items() if joints}


def _below(skeleton: Skeleton, tops: list[int]) -> dict[int, tuple[int, ...]]:
    """Return each of some joints, none of which hangs on another, with all that hangs on it."""
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
