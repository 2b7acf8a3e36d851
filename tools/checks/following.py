"""Following, checked on right and wrong repetitions: counts, ends, verdict, false ones, and whether `certainty` comes true.

    python -m checks.following FOLDER [--foreign|--others]
    python -m checks.following --sessions EXAMPLES

Without an option, rows `followed_by_others` follow those of own examples: with one example of the next person, and with two each
of the other people. Mirror images of these count, because some people are left-handed. Rows `repeated` say how much of the nine
other exercises, each repeated as often as it was recorded, is taken for the move. `--sessions` has rows `moves_others`: moves recognised with the examples of one, two and four other players.
FOLDER has one `.npz` for each person, with arrays `mNN_right_EE` and `mNN_wrong_EE`: repetition EE of exercise NN, (n, 22, 3)
metres, 30 Hz, joints as below. The example is the person's first right repetition; with `--foreign` that of the next person;
with `--others` the first two of each other person are examples.
EXAMPLES is a folder as for `mossar evaluate`: all moves of a player are followed at once, and a command is right if its
move leads, with the highest certainty, as its progress reaches 0.6. A move that never comes so far is wrong.
"""

import argparse
import random
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mossar_stream import FollowEvent, FollowState, Moves, Segmenter, Settings, Skeleton
from mossar_tools.evaluation.recognising import confirmed, judge, summary
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
FEW = 4  # players of whom one example of each move is enough
LOST = 1e9  # deviation of a repetition that was not done


def person_of(file: Path) -> Person:
    """Return the repetitions of a person, by exercise and by `right` and `wrong`."""
    with np.load(file) as arrays:
        found: Person = defaultdict(lambda: {"right": [], "wrong": []})
        for name in sorted(arrays.files):
            exercise, kind, _ = name.split("_")
            found[exercise][kind].append(arrays[name])
    return found


def followed(examples: Repetitions, repetitions: Repetitions, *, mirrored: bool = False) -> list[FollowEvent]:
    """Return the events of successive repetitions when a move with these examples is followed.

    Args:
        examples: Of the move.
        repetitions: Of one person.
        mirrored: Whether mirror images of the examples are followed, too.
    """
    moves = Moves(SKELETON)
    for example in examples:
        moves.add("it", example, fps=FPS)
    moves.set_rule("it", mirrored=mirrored)
    segmenter = Segmenter(SKELETON, fps=FPS, moves=moves, follow=("it",))
    events = [*segmenter.push(np.concatenate(repetitions)), *segmenter.end_take()]
    return [event for event in events if isinstance(event, FollowEvent)]


def examples_of_others(
    people: list[Person], person: Person, exercise: str
) -> tuple[Repetitions, Repetitions]:
    """Return the first right repetition of the next person, and the first two of each other person."""
    at = next(place for place, one in enumerate(people) if one is person)
    others = [one for one in people if one is not person]
    one = people[(at + 1) % len(people)][exercise]["right"][:1]
    return one, [example for other in others for example in other[exercise]["right"][:2]]


def area_of(right: NDArray[np.float64], wrong: NDArray[np.float64]) -> float:
    """Return the share of pairs whose wrong repetition has a larger deviation than the right one; ties count half."""
    return float(np.mean((wrong[:, None] > right) + 0.5 * (wrong[:, None] == right)))


def print_followed_by_others(people: list[Person]) -> None:
    """Print a row for one example of another person and one for two each of all others, with the worst person of each."""
    for place, kind in enumerate(("one other", "two each of all others")):
        found: list[list[tuple[float, float, float]]] = []
        for person in people:
            own = []
            for exercise, kinds in person.items():
                examples = examples_of_others(people, person, exercise)[place]
                right, wrong = (
                    followed(examples, kinds[which], mirrored=True) for which in ("right", "wrong")
                )
                off = abs(sum(event.status == "done" for event in right) - len(kinds["right"]))
                area = area_of(deviations(right, kinds["right"]), deviations(wrong, kinds["wrong"]))
                own.append((float(off == 0), float(off <= 1), area))
            found.append(own)
        exact, within, area = np.mean([row for own in found for row in own], axis=0)
        least = min(np.mean([row[0] for row in own]) for own in found)
        print(
            f"followed_by_others, {kind}: exact {exact:.2f} (worst person {least:.2f}), within one {within:.2f}, AUC {area:.3f}"
        )


def print_repeated(people: list[Person]) -> None:
    """Print how often other exercises count as the move when they are repeated, for the examples of each row."""
    for place, kind in enumerate(("own example", "one other", "two each of all others")):
        shares = []
        for person in people:
            for exercise, kinds in person.items():
                examples = kinds["right"][:1]
                if place > 0:
                    examples = examples_of_others(people, person, exercise)[place - 1]
                for name, own in person.items():
                    if name != exercise:
                        events = followed(examples, own["right"], mirrored=place > 0)
                        shares.append(sum(event.status == "done" for event in events) / len(own["right"]))
        print(f"repeated, {kind}: {np.mean(shares):.3f} of other exercises done")


def ends_of(repetitions: Repetitions) -> NDArray[np.float64]:
    """Return the end of each repetition, s."""
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
    """Return whether a move has come to the progress at which it is judged."""
    return state is not None and state.progress >= PLACE


def leads(states: Mapping[str, FollowState | None], move: str) -> bool:
    """Return whether a move is the one that is most likely being made."""
    return max(states, key=lambda name: state.certainty if (state := states[name]) else -1.0) == move


def print_sessions(folder: Path) -> None:
    """Print the share of commands in each session whose move leads."""
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


def print_moves_others(folder: Path) -> None:
    """Print the scores of recognition with the examples of one, two and four other players, drawn with a fixed seed.

    One and two players give two examples of each move, four give one.
    """
    sessions = [load_session(path) for path in session_labels(folder)]
    for count in (one for one in (1, 2, 4) if one < len(sessions)):
        found = []
        for session in sessions:
            rest = [other for other in sessions if other is not session]
            drawn = random.Random(f"{session.name}{count}").sample(rest, count)  # noqa: S311 - a fixed choice
            moves = Moves(session.skeleton)
            for other in drawn:
                for name, shown in other.examples.shown.items():
                    pairs = zip(shown, other.examples.fps[name], strict=True)
                    for positions, fps in list(pairs)[: 2 if count < FEW else 1]:
                        moves.add(name, positions, fps)
            found.append(judge(session, confirmed(session, moves, Settings())))
        print(f"moves_others, {count} {'player' if count == 1 else 'players'}: F1 {summary(found).f1:.3f}")


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
        print_moves_others(given.sessions)
        return
    if given.folder is None:
        parser.error("a folder is needed, or --sessions EXAMPLES")
    people = [person_of(file) for file in sorted(given.folder.glob("*.npz"))]
    of_others = given.foreign or given.others
    counts, ends, areas, said, sure = [], [], [], [], []
    false = others = performances = 0
    for person in people:
        for exercise, kinds in person.items():
            examples, right, wrong = kinds["right"][:1], kinds["right"][1:], kinds["wrong"]
            if of_others:
                examples = examples_of_others(people, person, exercise)[given.others]
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
            areas.append(area_of(deviations(own, right), deviations(bad, wrong)))
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
        early = f"{kept.sum() / performances:.2f} of the done ones, at a median progress of {np.median(places):.2f}"
        print(f"committed at {SURE}: {early}; {kept.mean():.2f} of {len(kept)} came true")
    if not of_others and len(people) > 1:
        print_followed_by_others(people)
        print_repeated(people)


if __name__ == "__main__":
    main()
