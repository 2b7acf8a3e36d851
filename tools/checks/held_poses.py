"""Rate of poses that are falsely reported as held, and the share of held poses that are found.

    python -m checks.held_poses LABELLED [EXAMPLES]

Of LABELLED the recordings of `QUIET` count, without a T-pose, a plank or a hand above the head; EXAMPLES is a folder as for
`mossar evaluate`, whose sessions count, too. The poses are made from the bodies of the recordings: the skeleton of each, upright,
with limbs where the pose has them. The second part holds each pose with that body, and with noise, other sizes and other
headings. A body without legs has no plank, and one arm alone (`vmci`) only that arm's part of the others; without hips
(`gesture_phase`, `vmci`) a pose is found as it was shown only, so that no other headings are tried.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import MossarError, Moves, PoseEvent, Segmenter, Settings, Skeleton, joint_places
from mossar_tools.console import Console
from mossar_tools.evaluation.sessions import load_session, session_labels
from mossar_tools.evaluation.takes import load_folder

QUIET = ("precog", "vmci", "gesture_phase")
FPS = 30.0
NOISE = 0.005  # m
MOST = 0.5  # false ones in 10 minutes
HELD = 3.0  # s
SIZES, HEADINGS = (0.7, 1.0, 1.25), (0, 90, 180)
# An upright body: x to its left, y up, z forwards, m.
_MIDDLE = {
    "hips": (0, 0.95, 0),
    "spine": (0, 1.15, 0),
    "chest": (0, 1.35, 0),
    "neck": (0, 1.48, 0),
    "head": (0, 1.65, 0),
}
_SIDE = {
    "shoulder": (0.18, 1.4, 0),
    "hip": (0.1, 0.9, 0),
    "knee": (0.1, 0.5, 0),
    "ankle": (0.1, 0.09, 0),
    "foot": (0.1, 0.03, 0.14),
}
_ARM = {"elbow": 0.28, "wrist": 0.53, "hand": 0.61}
# Markers of the right arm and the back, as `vmci` calls them, m: the body's left, up and forwards of a joint.
_MARKERS = {
    "Back_top": ("neck", (0, 0, 0)), "Back_left": ("left_hip", (0, 0.1, 0)), "Back_right": ("right_hip", (0, 0.1, 0)),
    "Shoulder": ("right_shoulder", (0, 0, 0)), "Elbow": ("right_elbow", (0, 0, 0)), "Hand_top": ("right_wrist", (0, 0, 0)),
    "Hand_left": ("right_hand", (0, 0.04, 0)), "Hand_right": ("right_hand", (0, -0.04, 0)),
    "Thumb": ("right_hand", (0, 0, 0.08)), "Index": ("right_hand", (0, 0.03, 0.05)), "Middle": ("right_hand", (0, 0, 0.05)),
}  # fmt: skip


class Recorded(msgspec.Struct, frozen=True):
    """A recording without any of the poses."""

    name: str
    skeleton: Skeleton
    positions: NDArray[np.float32]
    times: NDArray[np.float64]


def body(skeleton: Skeleton, left: tuple[float, ...], right: tuple[float, ...]) -> NDArray[np.float64]:
    """Return an upright body with straight arms in two directions, (J, 3) m; unknown joints lie at their parents."""
    slots = {**_MIDDLE}
    for side, sign, way in (("left", 1.0, left), ("right", -1.0, right)):
        turn = np.array([sign, 1.0, 1.0])
        slots |= {f"{side}_{part}": tuple(turn * place) for part, place in _SIDE.items()}
        shoulder = np.array(_SIDE["shoulder"])
        slots |= {
            f"{side}_{part}": tuple(turn * (shoulder + length * np.array(way)))
            for part, length in _ARM.items()
        }
    placed = np.zeros((len(skeleton), 3))
    known = {one: slot for slot, (one, other) in joint_places(skeleton).items() if one == other}
    for joint, parent in enumerate(skeleton.parents):
        name = skeleton.names[joint]
        if name in _MARKERS:
            slot, way = _MARKERS[name]
            placed[joint] = np.array(slots[slot]) + way
        elif joint in known:
            placed[joint] = slots[known[joint]]
        else:
            placed[joint] = placed[parent] if parent >= 0 else slots["hips"]
    return placed


def poses_of(skeleton: Skeleton) -> dict[str, NDArray[np.float64]]:
    """Return the poses that a skeleton can show, and how it stands, under an empty name."""
    down, out, up = (0.05, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    found = {
        "": body(skeleton, down, down),
        "t_pose": body(skeleton, out, out),
        "hand_up": body(skeleton, down, up),
    }
    if "left_knee" in joint_places(skeleton):
        forward = body(skeleton, (0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
        found["plank"] = np.stack([forward[:, 0], 0.5 - forward[:, 2], forward[:, 1]], axis=1)
    return found


def shown(skeleton: Skeleton) -> Moves:
    """Return the poses of a skeleton."""
    moves = Moves(skeleton)
    for name, pose in poses_of(skeleton).items():
        if name:
            moves.add_pose(name, pose)
    return moves


def session(skeleton: Skeleton, name: str, size: float, heading: float) -> NDArray[np.float32]:
    """Return a body that stands, takes a pose, holds it for `HELD` seconds, and stands again."""
    poses = poses_of(skeleton)
    share = (0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 30)))[:, None, None]
    still = np.repeat(poses[""][None], 45, axis=0)
    way = poses[""] + share * (poses[name] - poses[""])
    frames = np.concatenate(
        [still, way, np.repeat(poses[name][None], round(HELD * FPS), axis=0), way[::-1], still]
    )
    c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
    frames = size * frames @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    noisy: NDArray[np.float64] = frames + np.random.default_rng(0).normal(0, NOISE, frames.shape)
    return noisy.astype(np.float32)


def held(
    moves: Moves, skeleton: Skeleton, positions: NDArray[np.float32], times: NDArray[np.float64]
) -> list[PoseEvent]:
    """Return the events of poses."""
    segmenter = Segmenter(skeleton, Settings(), moves=moves)
    events = [*segmenter.push(positions, times), *segmenter.end_take()]
    return [event for event in events if isinstance(event, PoseEvent)]


def recordings(labelled: Path, examples: Path | None, console: Console) -> list[Recorded]:
    """Return all recordings without the poses."""
    takes = [
        Recorded(take.name, take.skeleton, take.positions, take.times)
        for take in load_folder(labelled, console.status)
    ]
    for path in session_labels(examples) if examples else ():
        found = load_session(path)
        takes.append(Recorded(f"sessions/{path.stem}", found.skeleton, found.positions, found.times))
    return [take for take in takes if take.name.startswith((*QUIET, "sessions"))]


def false_ones(takes: Sequence[Recorded], console: Console) -> float:
    """Print the rate of false poses, by folder; return the highest in 10 minutes."""
    groups: dict[str, list[Recorded]] = {}
    for take in takes:
        groups.setdefault(take.name.partition("/")[0], []).append(take)
    worst = 0.0
    console.line(f"{'recordings':<16}{'minutes':>8}{'entered':>9}{'held':>6}{'in 10 min':>11}")
    for group, own in groups.items():
        seconds = sum(float(take.times[-1] - take.times[0]) for take in own)
        said = Counter[tuple[str, str]]()
        for take in own:
            said.update(
                (event.status, event.name)
                for event in held(shown(take.skeleton), take.skeleton, take.positions, take.times)
            )
        entered, false = (
            sum(n for (status, _), n in said.items() if status == wanted) for wanted in ("entered", "held")
        )
        rate = 600 * false / max(seconds, 1e-9)
        worst = max(worst, rate)
        what = ", ".join(f"{name} {n}" for (status, name), n in said.most_common() if status == "held")
        console.line(f"{group:<16}{seconds / 60:>8.1f}{entered:>9}{false:>6}{rate:>11.2f}  {what}")
    return worst


def _has_hips(skeleton: Skeleton) -> bool:
    return {"left_hip", "right_hip"} <= joint_places(skeleton).keys()


def found_ones(skeletons: Sequence[Skeleton], console: Console) -> float:
    """Print the number of held poses that are reported exactly once; return their share."""
    right = total = 0
    for skeleton in skeletons:
        moves = shown(skeleton)
        for name in (pose.name for pose in moves.poses):
            stories = []
            for size in SIZES:
                for heading in HEADINGS if _has_hips(skeleton) else HEADINGS[:1]:
                    frames = session(skeleton, name, size, heading)
                    events = held(moves, skeleton, frames, np.arange(len(frames)) / FPS)
                    stories.append([event.name for event in events if event.status == "held"] == [name])
            right, total = right + sum(stories), total + len(stories)
            console.line(
                f"{len(skeleton):>3} joints, {name:<10}{sum(stories):>3} of {len(stories)} held once"
            )
    return right / max(total, 1)


def main() -> None:
    """Run the program; the exit status is 1 if too many are false, or one is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("labelled", type=Path)
    parser.add_argument("examples", type=Path, nargs="?")
    given = parser.parse_args()
    console = Console(sys.stdout, sys.stderr)
    try:
        takes = recordings(given.labelled, given.examples, console)
    except MossarError as error:
        parser.error(str(error))
    worst = false_ones(takes, console)
    share = found_ones(list(dict.fromkeys(take.skeleton for take in takes)), console)
    console.line(f"most false ones in 10 minutes: {worst:.2f} (at most {MOST:g}); found {share:.0%}")
    sys.exit(1 if worst > MOST or share < 1.0 else 0)


if __name__ == "__main__":
    main()
