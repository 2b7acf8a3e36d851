"""Following, checked on right and wrong repetitions: counts, ends, verdict, false ones, and whether `certainty` comes true.

    python -m checks.following FOLDER

FOLDER has one `.npz` for each person, with arrays `mNN_right_EE` and `mNN_wrong_EE`: repetition EE of exercise NN, (n, 22, 3)
metres, 30 Hz, joints as below. The example is the person's first right repetition.
"""

import argparse
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mossar_stream import FollowEvent, Moves, Segmenter, Skeleton

FPS = 30.0
NAMES = (
    "waist spine chest neck head head_tip left_collar left_shoulder left_elbow left_wrist right_collar right_shoulder "
    "right_elbow right_wrist left_hip left_knee left_ankle left_toes right_hip right_knee right_ankle right_toes"
)
PARENTS = (-1, 0, 1, 2, 3, 4, 3, 6, 7, 8, 3, 10, 11, 12, 0, 14, 15, 16, 0, 18, 19, 20)
SKELETON = Skeleton(tuple(NAMES.split()), PARENTS)
Repetitions = list[NDArray[np.float32]]
Person = dict[str, dict[str, Repetitions]]
LOST = 1e9  # deviation of a repetition that was not done


def person_of(file: Path) -> Person:
    """Return the repetitions of a person, by exercise and by `right` and `wrong`."""
    with np.load(file) as arrays:
        found: Person = defaultdict(lambda: {"right": [], "wrong": []})
        for name in sorted(arrays.files):
            exercise, kind, _ = name.split("_")
            found[exercise][kind].append(arrays[name])
    return found


def followed(example: NDArray[np.float32], repetitions: Repetitions) -> list[FollowEvent]:
    """Return what is reported of repetitions, one after the other, when an example is followed."""
    moves = Moves(SKELETON)
    moves.add("it", example, fps=FPS)
    segmenter = Segmenter(SKELETON, fps=FPS, moves=moves, follow=("it",))
    events = [*segmenter.push(np.concatenate(repetitions)), *segmenter.end_take()]
    return [event for event in events if isinstance(event, FollowEvent)]


def ends_of(repetitions: Repetitions) -> NDArray[np.float64]:
    """Return when each repetition ends, s."""
    return np.cumsum([len(one) for one in repetitions]) / FPS


def deviations(events: list[FollowEvent], repetitions: Repetitions) -> NDArray[np.float64]:
    """Return the deviation of each repetition, `LOST` of those that were not done."""
    ends = ends_of(repetitions)
    found = np.full(len(ends), LOST)
    for event in events:
        middle = (event.start + event.time) / 2
        if event.status == "done" and middle < ends[-1]:
            found[np.searchsorted(ends, middle)] = event.deviation
    return found


def came_true(events: list[FollowEvent]) -> list[tuple[float, bool]]:
    """Return the certainty of each message, and whether the performance was done."""
    done = {event.id for event in events if event.status == "done"}
    return [(e.certainty, e.id in done) for e in events if e.status in ("begun", "progress")]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.following", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("folder", type=Path)
    files = sorted(parser.parse_args().folder.glob("*.npz"))
    counts, ends, areas, said = [], [], [], []
    false = others = 0
    for person in map(person_of, files):
        for exercise, kinds in person.items():
            example, right, wrong = kinds["right"][0], kinds["right"][1:], kinds["wrong"]
            odd = [own["right"][2] for name, own in person.items() if name != exercise]
            own, bad, foreign = (followed(example, repetitions) for repetitions in (right, wrong, odd))
            said += [*came_true(own), *came_true(bad), *came_true(foreign)]
            times = [event.time for event in own if event.status == "done"]
            counts.append(len(times) - len(right))
            ends += [min([abs(time - end) for time in times], default=9.0) for end in ends_of(right)]
            a, b = deviations(own, right), deviations(bad, wrong)
            areas.append(float(np.mean((b[:, None] > a) + 0.5 * (b[:, None] == a))))
            false += sum(event.status == "done" for event in foreign)
            others += len(odd)
    off = np.abs(counts)
    print(f"takes {len(off)}: exact {np.mean(off == 0):.2f}, within one {np.mean(off <= 1):.2f}")
    print(f"ends: median {np.median(ends):.2f} s, 90 % {np.quantile(ends, 0.9):.2f} s")
    print(f"right against wrong: AUC {np.mean(areas):.3f}; done in other exercises {false / others:.3f}")
    says, true = np.array(said).T
    print("certainty  messages  said  came true")
    for low in np.arange(0.0, 1.0, 0.1):
        within = (says >= low) & (says < low + 0.1 + (low > 0.85))
        if within.any():
            print(f"{low:9.1f} {within.sum():9d} {says[within].mean():5.2f} {true[within].mean():10.2f}")


if __name__ == "__main__":
    main()
