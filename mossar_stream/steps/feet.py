"""Feet: the joints or markers of each foot, by name."""

from mossar_stream.errors import FrameError
from mossar_stream.joint_names import plain_name
from mossar_stream.moves.joints import known_joints
from mossar_stream.settings.feet import MOST_POINTS, SIDES, parse_feet
from mossar_stream.skeleton import Skeleton

MOST_TOPS = 4  # joints that are above the feet
# Markers of Plug-in Gait, of its foot model, of CAST, CMU and OpenSim, and joints of pose estimators; the letter is the side.
_MARKERS = (
    "{c}ank {c}hee {c}toe",
    "{c}lm {c}mm {c}mt1 {c}mt5 {c}cal",
    "{c}lm {c}mt1 {c}mt5 {c}cal",
    "{c}ank {c}toe {c}mt5 {c}mt1",
    "{c}cal {c}mt1 {c}mt2 {c}mt3 {c}mt4 {c}mt5",
    "{c}heel {c}toetip {c}toelat {c}toemed",
    "{s}ankle {s}heel {s}footindex {s}bigtoe",
    "{c}ankle {c}heel {c}bigtoe {c}smalltoe",
)
_TOPS = ("lfhd", "rfhd", "lbhd", "rbhd", "c7", "strn", "clav", "sacr", "lasi", "rasi", "lpsi", "rpsi")


def feet_of(skeleton: Skeleton, named: str = "") -> dict[str, tuple[int, ...]]:
    """Return the joints of each foot: heels and toes where there are, or else ankles.

    Args:
        skeleton: Of the performer.
        named: A text for `parse_feet`; empty for joints that are known by name.

    Raises:
        FrameError: If a joint is not there, or the feet are not known.

    Example:
        >>> feet_of(Skeleton(("hip", "LANK", "LTOE", "RANK", "RTOE")))
        {'left': (1, 2), 'right': (3, 4)}
    """
    if named:
        return {
            side: tuple(_place(skeleton, name) for name in names) for side, names in parse_feet(named).items()
        }
    place = {plain_name(name): joint for joint, name in reversed(list(enumerate(skeleton.names)))}
    feet: dict[str, tuple[int, ...]] = {
        side: _by_markers(place, side) or _by_joints(skeleton, side) for side in SIDES
    }
    if not all(feet.values()):
        raise FrameError(
            "steps need ankles or toes on both sides; --feet left=A,B right=C,D says which joints they are"
        )
    return feet


def tops_of(skeleton: Skeleton) -> tuple[int, ...]:
    """Return joints that are above the feet of a performer that stands: the head, or else the trunk."""
    known = known_joints(skeleton)
    for slot in ("head", "neck", "chest", "spine", "hips"):
        if slot in known:
            return (known[slot],)
    place = {plain_name(name): joint for joint, name in reversed(list(enumerate(skeleton.names)))}
    found = [place[name] for name in _TOPS if name in place]
    slots = [
        known[slot] for slot in ("left_shoulder", "right_shoulder", "left_hip", "right_hip") if slot in known
    ]
    root = (skeleton.root,) if skeleton.root >= 0 else ()
    return (*found[:MOST_TOPS],) or (*slots,) or root


def _by_markers(place: dict[str, int], side: str) -> tuple[int, ...]:
    """Return the foot's markers by the names that have most of them; at least two, one that is no ankle."""
    sets = [[name.format(c=side[0], s=side) for name in names.split()] for names in _MARKERS]
    best = max(sets, key=lambda names: sum(name in place for name in names))
    found = [place[name] for name in best if name in place]
    return tuple(found[:MOST_POINTS]) if len(found) >= 2 else ()


def _by_joints(skeleton: Skeleton, side: str) -> tuple[int, ...]:
    known = known_joints(skeleton)
    return tuple(known[slot] for slot in (f"{side}_ankle", f"{side}_foot") if slot in known)


def _place(skeleton: Skeleton, name: str) -> int:
    try:
        return skeleton.index(name)
    except FrameError as error:
        raise FrameError(f"feet: {error}") from None
