"""Following, checked on right and wrong repetitions: counts, ends, verdict, false ones, and whether `certainty` comes true.

    python -m checks.following FOLDER [--foreign|--others]
    python -m checks.following --sessions EXAMPLES

FOLDER has one `.npz` for each person, with arrays `mNN_right_EE` and `mNN_wrong_EE`: repetition EE of exercise NN, (n, 22, 3)
metres, 30 Hz, joints as below. The example is the person's first right repetition; with `--foreign` that of the next person;
with `--others` the first two of each other person are examples.
EXAMPLES is a folder as for `mossar evaluate`: all moves of a player are followed at once, and a command is right if its
move leads, with the highest certainty, as its progress reaches 0.6. A move that never comes so far is wrong.
"""

import argparse
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mossar_stream import FollowEvent, FollowState, Moves, Segmenter, Skeleton
from mossar_tools.evaluation.sessions import Session, load_session, session_labels

FPS = 30.0
NAMES = (
    "waist spine chest neck head head_tip left_collar left_shoulder left_elbow left_wrist right_collar right_shoulder "
    "right_elbow right_wrist left_hip left_knee left_ankle left_toes right_hip right_knee right_ankle right_toes"
)
PARENTS = (-1, 0, 1, 2, 3, 4, 3, 6, 7, 8, 3, 10, 11, 12, 0, 14, 15, 16, 0, 18, 19, 20)
SKELETON = Skeleton(tuple(NAMES.split()), PARENTS)
Repetitions = list[NDArray[np.float32]]
Person = dict[str, dict[str, Repetitions]]
SURE = 0.9  # certainty at which a game commits itself
PLACE = 0.6  # progress at which moves on command are judged
LOST = 1e9  # deviation of a repetition that was not done


def person_of(file: Path) -> Person:
    """Return the repetitions of a person, by exercise and by `right` and `wrong`."""
    with np.load(file) as arrays:
        found: Person = defaultdict(lambda: {"right": [], "wrong": []})
        for name in sorted(arrays.files):
            exercise, kind, _ = name.split("_")
            found[exercise][kind].append(arrays[name])
    return found


def followed(examples: Repetitions, repetitions: Repetitions) -> list[FollowEvent]:
    """Return what is reported of repetitions, one after the other, when a move with these examples is followed."""
    moves = Moves(SKELETON)
    for example in examples:
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


def commitments(events: list[FollowEvent]) -> list[tuple[float, bool]]:
    """Return the progress at which each performance was first reported with `SURE`, and whether it was done."""
    done = {event.id for event in events if event.status == "done"}
    found: dict[str, float] = {}
    for event in events:
        if event.status in ("begun", "progress") and event.certainty >= SURE:
            found.setdefault(event.id, event.progress)
    return [(progress, name in done) for name, progress in found.items()]


def led(session: Session) -> list[bool | None]:
    """Return of each command whether its move leads once as its progress reaches `PLACE`; None if it never does.

    The first of two commands of one move does not count: the try was bad.
    """
    moves = session.examples.moves(slice(None))
    segmenter = Segmenter(session.skeleton, fps=session.fps, moves=moves, follow=True)
    seen: list[Mapping[str, FollowState | None]] = []
    for position, time in zip(session.positions, session.times.tolist(), strict=True):
        segmenter.push(position, time)
        seen.append(segmenter.following)
    found: list[bool | None] = []
    later = [*(move for _, _, move in session.commands[1:]), None]
    for (begin, end, move), after in zip(session.commands, later, strict=True):
        if move == after:
            continue
        arrivals = [
            k for k in range(max(begin, 1), end) if is_at(seen[k][move]) and not is_at(seen[k - 1][move])
        ]
        found.append(any(leads(seen[k], move) for k in arrivals) if arrivals else None)
    return found


def is_at(state: FollowState | None) -> bool:
    """Tell whether a move has come to the progress at which it is judged."""
    return state is not None and state.progress >= PLACE


def leads(states: Mapping[str, FollowState | None], move: str) -> bool:
    """Tell whether a move is the one that is most likely being made."""
    return max(states, key=lambda name: state.certainty if (state := states[name]) else -1.0) == move


def print_sessions(folder: Path) -> None:
    """Print for each session how often the right move leads."""
    found: list[bool | None] = []
    for path in session_labels(folder):
        own = led(load_session(path))
        print(
            f"{path.stem}: {own.count(True)} of {len(own)} lead at {PLACE}, {own.count(None)} never came so far"
        )
        found += own
    reached = [one for one in found if one is not None]
    if reached:
        print(
            f"all {len(found)}: {sum(reached) / len(found):.3f}; of those that came so far {np.mean(reached):.3f}"
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.following", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("folder", type=Path, nargs="?")
    whose = parser.add_mutually_exclusive_group()
    whose.add_argument("--foreign", action="store_true", help="follow the example of the next person")
    whose.add_argument("--others", action="store_true", help="follow two examples of each other person")
    parser.add_argument("--sessions", type=Path, metavar="EXAMPLES", help="moves on command instead")
    given = parser.parse_args()
    if given.sessions is not None:
        print_sessions(given.sessions)
        return
    if given.folder is None:
        parser.error("a folder is needed, or --sessions EXAMPLES")
    people = [person_of(file) for file in sorted(given.folder.glob("*.npz"))]
    counts, ends, areas, said, sure = [], [], [], [], []
    false = others = performances = 0
    for person, following in zip(people, people[1:] + people[:1], strict=True):
        for exercise, kinds in person.items():
            examples, right, wrong = kinds["right"][:1], kinds["right"][1:], kinds["wrong"]
            if given.foreign:
                examples, right = following[exercise]["right"][:1], kinds["right"]
            elif given.others:
                others_of = [other for other in people if other is not person]
                examples = [one for other in others_of for one in other[exercise]["right"][:2]]
                right = kinds["right"]
            odd = [own["right"][2] for name, own in person.items() if name != exercise]
            own, bad, foreign = (followed(examples, repetitions) for repetitions in (right, wrong, odd))
            for events in (own, bad, foreign):
                said += came_true(events)
                sure += commitments(events)
                performances += sum(event.status == "done" for event in events)
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
    places, kept = np.array(sure).reshape(-1, 2).T
    if len(places):
        early = f"{kept.sum() / performances:.2f} of what is done, at a median progress of {np.median(places):.2f}"
        print(f"committed at {SURE}: {early}; {kept.mean():.2f} of {len(kept)} came true")


if __name__ == "__main__":
    main()
