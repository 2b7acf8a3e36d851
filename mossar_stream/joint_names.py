"""Names of joints: the one table of them, and the one way to read a name.

A name is read in words: "J_Bip_L_UpperArm", "Bip01 L UpperArm", "upper_arm.L", "upperarm_l", "lUpperArm" and "左腕" are all the
upper arm of the left side. Words that a program writes before or behind ("Bip01", "DEF-", "_JNT"), and words that most joints
of a skeleton share, do not count. A name with any other word more is not known: "upperarm_twist_01_l" is no upper arm.
"""

import functools
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from mossar_stream.events import Side

SIDES: tuple[Side, Side] = ("left", "right")
REMEMBERED = 64  # joint sets whose results are cached

# Names of joints, as words without their side; of several that a set has, the first one is used. A humanoid's LeftShoulder
# is the collar bone and its LeftUpperArm the shoulder. Of joints with numbers, `#` is the lowest, `##` the highest, and
# `###` the highest if that is 2 or more.
_TRUNK = {
    "hips": "spinebase hipcenter hipcentre hips pelvis midhip root lowerbody hip waist",
    "spine": "spinemid spine lowerback ab abdomen abdomenlower spinenavel spinenaval upperbody spine# lowerspine stomach l5 l3 "
    "torso#",
    "chest": "spineshoulder shouldercenter shouldercentre upperchest chestupper spine### thorax chest spinechest upperbody2 "
    "upperbody3 t8 t12 spine## chest# torso##",
    "neck": "neck upperneck lowerneck necklower neck#",
    "head": "head nose head#",
    "torso": "torso",
}
_SIDED = {
    "collar": "collar clavicle scapula shoulder",
    "shoulder": "upperarm uparm arm uarm shldr shoulder clavicle",
    "elbow": "lowerarm lowarm forearm farm larm humerus elbow",
    "wrist": "radius wrist hand",
    "hand": "hand index",
    "hip": "upperleg upleg thigh hip hipjoint leg",
    "knee": "lowerleg lowleg shin shank calf knee leg femur",
    "ankle": "ankle tibia foot",
    "foot": "foot toes toebase footindex ball toe bigtoe",
}
# Trunks as programs number or name them, from the hips up, of which the lowest is the spine and the highest the chest.
_TRUNK_WORDS = frozenset(
    [
        "spinemid",
        "spinenavel",
        "spinenaval",
        "spine",
        "spinechest",
        "spineshoulder",
        "lowerback",
        "upperback",
        "thorax",
        "ab",
        "abdomen",
        "abdomenlower",
        "abdomenupper",
        "chest",
        "chestlower",
        "chestupper",
        "upperchest",
        "upperbody",
        "l5",
        "l3",
        "t12",
        "t8",
        "lowerspine",
        "middlespine",
        "stomach",
        "torso",
    ]
)
_VERTEBRAE = re.compile(r"l[35]|t8|t12")  # if there is a pelvis; alone they are markers on the skin
# Words that programs write with every joint.
_IDLE = frozenset(
    [
        "jnt",
        "joint",
        "bone",
        "bip",
        "biped",
        "valve",
        "def",
        "j",
        "b",
        "c",
        "m",
        "x",
        "bend",
        "stretch",
        "skel",
        "mixamorig",
        "armature",
    ]
)
# Words of joints that do not belong to the body, however many names have them.
_MEANT = frozenset(
    [
        "twist",
        "roll",
        "ik",
        "fk",
        "pole",
        "target",
        "ctrl",
        "control",
        "end",
        "nub",
        "tip",
        "thumb",
        "finger",
        "fingers",
        "index",
        "middle",
        "ring",
        "pinky",
        "eye",
        "ear",
        "jaw",
        "left",
        "right",
        "l",
        "r",
    ]
)
_JAPANESE = {
    "上半身": "upper body",
    "下半身": "lower body",
    "センター": "center",
    "全ての親": "mother",
    "骨盤": "pelvis",
    "背骨": "spine",
    "胸": "chest",
    "首": "neck",
    "頭": "head",
    "鎖骨": "collar",
    "肩": "collar",
    "腕": "upper arm",
    "ひじ": "elbow",
    "肘": "elbow",
    "手首": "wrist",
    "手": "hand",
    "足首": "ankle",
    "足先": "toe",
    "足": "upper leg",
    "太もも": "thigh",
    "腿": "thigh",
    "ひざ": "knee",
    "膝": "knee",
    "すね": "shin",
    "つま先": "toe",
    "爪先": "toe",
    "親指": "thumb",
    "人指": "index finger",
    "人差指": "index finger",
    "人差し指": "index finger",
    "中指": "middle finger",
    "薬指": "ring finger",
    "小指": "pinky finger",
    "捩": "twist",
    "目": "eye",
    "左": "left",
    "右": "right",
}
_JAPANESE_WORDS = re.compile("|".join(sorted(_JAPANESE, key=len, reverse=True)))
_WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+|[^\W\d_a-zA-Z]+")
_PLAIN_PARTS = frozenset(
    key.rstrip("#") for keys in (*_TRUNK.values(), *_SIDED.values()) for key in keys.split()
)
_PARTS = _PLAIN_PARTS | _TRUNK_WORDS
_MOST_OF_A_SIDE = 1  # the highest number of a joint of an arm or a leg that is no further part of it


class JointName(NamedTuple):
    """A name as it was read.

    Args:
        side: `left`, `right`, or empty.
        part: The part of a side or of the trunk, in the words of the table; empty if it is not known.
        number: Its digits, as written.
        rest: All words but the side: the joint of the other side has the same.
        extra: Number of ignored kinds of words: of two names of one joint, the plainer one is used.
    """

    side: str
    part: str
    number: str
    rest: tuple[str, ...]
    extra: int


def plain_name(name: str) -> str:
    """Return a name's letters and digits, small, without the namespace before a colon: for sets that have exact names.

    Example:
        >>> plain_name("mixamorig:Left_Hand")
        'lefthand'
    """
    return re.sub(r"[^a-z0-9]", "", name.lower().rpartition(":")[2])


def words_of(name: str) -> tuple[str, ...]:
    """Return the words of a name, small: at separators, capitals and digits; Japanese ones in English.

    Example:
        >>> words_of("Bip01 L UpperArm"), words_of("左ひじ"), words_of("a|LeftUpLeg")
        (('bip', '01', 'l', 'upper', 'arm'), ('left', 'elbow'), ('left', 'up', 'leg'))
    """
    text = unicodedata.normalize("NFKC", name)
    text = re.split(r"[:|/]", text.rstrip(":|/"))[-1]
    text = _JAPANESE_WORDS.sub(lambda found: f" {_JAPANESE[found[0]]} ", text)
    return tuple(word.lower() for word in _WORD.findall(text))


def read_joint_names(names: Iterable[str]) -> tuple[JointName, ...]:
    """Return the meaning of the names of a skeleton's joints.

    Example:
        >>> [(name.side, name.part) for name in read_joint_names(["thigh_l", "RightUpLeg", "Spine1", "rod"])]
        [('left', 'thigh'), ('right', 'upleg'), ('', 'spine'), ('', '')]
    """
    return _read(tuple(names))


@functools.lru_cache(REMEMBERED)
def _read(names: tuple[str, ...]) -> tuple[JointName, ...]:
    words = [words_of(name) for name in names]
    counts = Counter(word for own in words for word in set(own))
    shared = (
        {word for word, count in counts.items() if len(names) >= 4 and 2 * count >= len(names)}
        - _MEANT
        - _PARTS
    )
    return tuple(_read_words(own, shared) for own in words)


def _read_words(words: tuple[str, ...], shared: set[str]) -> JointName:
    sides = [word for word in words if word in ("left", "right", "l", "r")]
    joined = "".join(words)
    if _VERTEBRAE.fullmatch(joined):
        return JointName("", joined, "", words, 0)
    side = {"l": "left", "r": "right"}.get(sides[0][0], "") if len(sides) == 1 else ""
    rest = tuple(word for word in words if word not in sides) if side else words
    # A hip joint is a hip in a set of joints; Acclaim's is a bone above it.
    passed_over = shared & {"joint"}
    for extra, idle in enumerate((frozenset[str](), _IDLE, frozenset(shared))):
        passed_over |= idle
        kept = [word for word in rest if word not in passed_over]
        key = "".join(word for word in kept if not word.isdigit())
        number = kept[-1] if kept and kept[-1].isdigit() else ""
        if key in _PARTS and (side or not sides):
            return JointName(side, key, number, rest, extra)
        own_side, part = ("", "") if side else _side_within(key)
        if part:
            plain = (part, number) if own_side else rest
            return JointName(own_side, part, number, plain, extra)
    return JointName(side, "", "", rest, 0)


def _side_within(key: str) -> tuple[str, str]:
    """Return side and part of a word that has both, such as `lfemur` or `shoulderleft`."""
    for side in SIDES:
        for part in (
            key.removeprefix(side),
            key.removesuffix(side),
            key[1:] if key[:1] == side[0] else key,
        ):
            if part != key and part in _PARTS:
                return side, part
    return "", ""


def find_joints(names: Sequence[str]) -> dict[str, int]:
    """Return the joints that are known by name.

    Args:
        names: Of the joints of a skeleton.

    Returns:
        Index of each joint that is there: `hips`, `spine`, `chest`, `neck`, `head`, `torso`; and of both sides, as in the example,
        `collar`, `shoulder`, `elbow`, `wrist`, `hand`, `hip`, `knee`, `ankle`, `foot`.

    Example:
        >>> find_joints(["pelvis", "thigh_l", "calf_l", "foot_l", "ball_l"])
        {'hips': 0, 'left_hip': 1, 'left_knee': 2, 'left_ankle': 3, 'left_foot': 4}
    """
    return dict(_find(tuple(names)))


@functools.lru_cache(REMEMBERED)  # asked many times of each
def _find(names: tuple[str, ...]) -> dict[str, int]:
    read = _read(names)
    places = _places(read)
    found: dict[str, int] = {}
    for side, part, keys in _in_turn():
        slot = f"{side}_{part}" if side else part
        for key in keys.split():
            joint = _of_key(places, read, key, side)
            # Else it is the leg above it.
            is_knee = (part, key) == (
                "hip",
                "leg",
            ) and f"{side}_knee" not in found
            if joint is not None and joint not in found.values() and not is_knee:
                found[slot] = joint
                break
    _number_a_spine_of_numbers(found, read)
    order = [*_TRUNK, *(f"{side}_{part}" for side in SIDES for part in _SIDED)]
    return {slot: found[slot] for slot in order if slot in found}


def _in_turn() -> Iterator[tuple[str, str, str]]:
    """Yield side, part and keys, in the order in which joints are taken.

    The remaining shoulder joints are collar bones. Of a leg and a knee the leg is the upper one, so knees come before hips.
    """
    yield from (("", part, keys) for part, keys in _TRUNK.items())
    late = ("knee", "hip", "ankle", "foot", "collar")
    for side in SIDES:
        for part in (*(part for part in _SIDED if part not in late), *late):
            yield side, part, _SIDED[part]


def _places(read: Sequence[JointName]) -> dict[tuple[str, str], list[int]]:
    """Return the joints of each side and part, those first whose name is plainest."""
    has_pelvis = any(name.part == "pelvis" for name in read)
    places: dict[tuple[str, str], list[int]] = {}
    for joint in sorted(range(len(read)), key=lambda j: (read[j].extra, int(read[j].number or -1), j)):
        name = read[joint]
        if name.part and (has_pelvis or not _VERTEBRAE.fullmatch(name.part)):
            places.setdefault((name.side, name.part), []).append(joint)
    return places


def _of_key(
    places: dict[tuple[str, str], list[int]], read: Sequence[JointName], key: str, side: str
) -> int | None:
    part = key.rstrip("#")
    if not side and part[-1].isdigit() and not _VERTEBRAE.fullmatch(part):
        part, number = part[:-1], part[-1]
        return next((joint for joint in places.get((side, part), ()) if read[joint].number == number), None)
    joints = places.get((side, part), [])
    if key.endswith("#"):
        numbered = [
            joint for joint in joints if int(read[joint].number or -1) >= (2 if key.endswith("###") else 0)
        ]
        return numbered[-1 if key.endswith("##") else 0] if numbered else None
    for joint in joints:
        number = read[joint].number
        if not number or (side and key != "index" and int(number) <= _MOST_OF_A_SIDE):
            return joint
    return None


def _number_a_spine_of_numbers(found: dict[str, int], read: Sequence[JointName]) -> None:
    """Find hips, neck and head in a spine that is only numbered (`spine`, `spine.001` … `spine.006`), as Rigify's is."""
    if {"hips", "neck", "head"} & found.keys():
        return
    chain = sorted(
        (int(name.number or 0), joint)
        for joint, name in enumerate(read)
        if (name.side, name.part) == ("", "spine")
    )
    joints = [joint for _, joint in chain]
    if len(joints) < 5 or chain[0][0]:
        return
    found["hips"], found["spine"], found["head"] = joints[0], joints[1], joints[-1]
    above = max(2, len(joints) - 3)  # two of the neck, and the head
    found["neck"], found["chest"] = joints[above], joints[above - 1]


def trunk_joints(names: Sequence[str]) -> list[int]:
    """Return the joints of the trunk between hips and neck that are known by name, from below.

    Example:
        >>> trunk_joints(["Hips", "Spine2", "Spine", "Neck", "Spine1"])
        [2, 4, 1]
    """
    found, read = find_joints(names), read_joint_names(names)
    others = {joint for slot, joint in found.items() if slot in ("hips", "neck", "head")}
    order = list(_HEIGHTS)
    trunk = [
        joint
        for joint, name in enumerate(read)
        if not name.side and name.part in _HEIGHTS and joint not in others
    ]
    torsos = [joint for joint in trunk if read[joint].part == "torso"]
    if len(torsos) == 1:  # of a sensor whose torso is all of the trunk
        trunk.remove(torsos[0])
    if "neck" in found and read[found["neck"]].part == "spine":  # and so is the head
        above = int(read[found["neck"]].number)
        trunk = [j for j in trunk if read[j].part != "spine" or int(read[j].number or 0) < above]
    return sorted(trunk, key=lambda j: (order.index(read[j].part), int(read[j].number or 0), j))


_HEIGHTS = [
    "torso",
    "lowerback",
    "lowerspine",
    "stomach",
    "ab",
    "abdomenlower",
    "abdomen",
    "abdomenupper",
    "l5",
    "l3",
    "spinemid",
    "spinenavel",
    "spinenaval",
    "upperbody",
    "spine",
    "middlespine",
    "upperback",
    "t12",
    "chestlower",
    "chest",
    "t8",
    "spinechest",
    "chestupper",
    "upperchest",
    "thorax",
    "spineshoulder",
]


def counterparts(names: Sequence[str]) -> list[int]:
    """Return the counterpart of each joint, whose name differs in the side only; itself without a side, -1 if there is none.

    Example:
        >>> counterparts(["hips", "thumb_01_l", "thumb_01_r", "LeftEye", "lfingers", "rfingers"])
        [0, 2, 1, -1, 5, 4]
    """
    read = read_joint_names(names)
    place = {(name.side, name.rest): joint for joint, name in reversed(list(enumerate(read)))}
    other = {"left": "right", "right": "left"}
    letters = {"l": "r", "r": "l"}
    whole = {name: joint for joint, name in reversed(list(enumerate(names)))}

    def of_letters(joint: int) -> int:
        """Return the joint with the other side's first letter, as of `lthumb`."""
        name = names[joint]
        return whole.get(letters.get(name[:1], "") + name[1:], joint)

    return [
        place.get((other[name.side], name.rest), -1) if name.side else of_letters(joint)
        for joint, name in enumerate(read)
    ]
