"""Recognising: results of the moves of sessions, and of segmented examples of other people."""

from collections import Counter
from collections.abc import Mapping, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import MoveEvent, Moves, Segmenter, Settings
from mossar_tools.evaluation.sessions import Examples, Session

SPEED_AVERAGED = 0.2  # s
DRAWS = 25  # random draws of other people's examples
SIDES = ("left", "right")


class Hit(msgspec.Struct, frozen=True):
    """A command that was recognised.

    Args:
        move: Its name.
        delay: s after the peak of speed in the command's time.
        limb: The limb that led.
    """

    move: str
    delay: float
    limb: str


class Outcome(msgspec.Struct, frozen=True):
    """The results of one session.

    Args:
        session: Its name.
        hits: Commands that were recognised.
        missed: Moves that were not recognised.
        false: Wanted and recognised move of each wrong answer; wanted is empty outside all commands.
    """

    session: str
    hits: list[Hit]
    missed: list[str]
    false: list[tuple[str, str]]


class Summary(msgspec.Struct, frozen=True):
    """Scores of several sessions; delays as 10 %, 50 %, 90 % quantiles, s."""

    recall: float
    precision: float
    f1: float
    delays: list[float]
    sided: int  # hits of moves whose names contain a side
    right_side: int  # of these, with a limb of that side


def confirmed(session: Session, moves: Moves, settings: Settings) -> list[MoveEvent]:
    """Return the moves that are confirmed in a session."""
    segmenter = Segmenter(session.skeleton, settings, fps=session.fps, moves=moves)
    events = [*segmenter.push(session.positions, session.times), *segmenter.end_take()]
    return [event for event in events if isinstance(event, MoveEvent) and event.status == "confirmed"]


def judge(session: Session, found: Sequence[MoveEvent]) -> Outcome:
    """Return the results of a session.

    The first right answer within a command is a hit. Every other answer in it is false.
    """
    times = session.times
    frames = [int(np.searchsorted(times, event.decided_time - 1e-9)) for event in found]
    speed = _speed(session)
    hits, missed, false = [], [], []
    commands = session.commands
    for place, (begin, end, wanted) in enumerate(commands):
        if place + 1 < len(commands) and commands[place + 1][2] == wanted:
            continue  # a bad try, which the next command repeats
        hit = False
        for frame, event in zip(frames, found, strict=True):
            if not begin <= frame < end:
                continue
            if event.name == wanted and not hit:
                hit = True
                peak = float(times[begin + int(np.argmax(speed[begin:end]))])
                hits.append(Hit(wanted, event.decided_time - peak, event.limb))
            else:
                false.append((wanted, event.name))
        if not hit:
            missed.append(wanted)
    return Outcome(session.name, hits, missed, false)


def _speed(session: Session) -> NDArray[np.float64]:
    """Return (n,) m/s, mean over the joints relative to the centre, averaged over the last `SPEED_AVERAGED`."""
    root = session.skeleton.root
    positions = session.positions
    centre = positions[:, [root]] if root >= 0 else positions.mean(axis=1, keepdims=True)
    steps = np.linalg.norm(np.diff(positions - centre, axis=0), axis=2)
    speed = np.concatenate([[0.0], np.nan_to_num(np.nanmean(steps, axis=1))]) * session.fps
    width = max(1, round(SPEED_AVERAGED * session.fps))
    return np.convolve(speed, np.full(width, 1 / width))[: len(speed)]


def summary(outcomes: Sequence[Outcome]) -> Summary:
    """Return the scores of all sessions together."""
    hits = [hit for outcome in outcomes for hit in outcome.hits]
    missed = sum(len(outcome.missed) for outcome in outcomes)
    false = sum(len(outcome.false) for outcome in outcomes)
    sided = [hit for hit in hits if side_of(hit.move) is not None]
    count = len(hits)
    return Summary(
        recall=count / max(1, count + missed),
        precision=count / max(1, count + false),
        f1=2 * count / max(1, 2 * count + missed + false),
        delays=np.quantile([hit.delay for hit in hits] or [np.nan], [0.1, 0.5, 0.9]).tolist(),
        sided=len(sided),
        right_side=sum(str(side_of(hit.move)) in hit.limb for hit in sided),
    )


def side_of(move: str) -> str | None:
    """Return the side in the name of a move.

    Example:
        >>> side_of("jab_left"), side_of("duck")
        ('left', None)
    """
    found = [side for side in SIDES if side in move.lower()]
    return found[0] if len(found) == 1 else None


def by_move(outcomes: Sequence[Outcome]) -> dict[str, Counter[str]]:
    """Return the numbers of hits, misses and confusions (`as NAME`) of each move."""
    table: dict[str, Counter[str]] = {}
    for outcome in outcomes:
        for hit in outcome.hits:
            table.setdefault(hit.move, Counter())["hit"] += 1
        for name in outcome.missed:
            table.setdefault(name, Counter())["missed"] += 1
        for wanted, said in outcome.false:
            table.setdefault(wanted, Counter())[f"as {said}"] += 1
    return dict(sorted(table.items()))


def other_people(players: Mapping[str, Examples], each: int, seed: int = 0) -> tuple[int, int]:
    """Return the number of segmented examples that those of other people recognise, and the number of all.

    For each move, `each` examples of other people are drawn at random; the nearest one gives the move. This is repeated
    `DRAWS` times, and both numbers are sums over them.

    Args:
        players: Examples of each player, with the same joints.
        each: Examples of each move.
        seed: Seed of the draws.
    """
    rng = np.random.default_rng(seed)
    everything = [
        (who, name, k)
        for who, own in players.items()
        for name in own.shown
        for k in range(len(own.shown[name]))
    ]
    costs = _all_costs(players, everything)
    right = total = 0
    for who in players:
        others = [i for i, entry in enumerate(everything) if entry[0] != who]
        names = sorted({everything[i][1] for i in others})
        mine = [i for i, entry in enumerate(everything) if entry[0] == who and entry[1] in names]
        for _ in range(DRAWS):
            drawn = [
                i
                for name in names
                for i in rng.permutation([j for j in others if everything[j][1] == name])[:each]
            ]
            nearest = np.argmin(costs[np.ix_(mine, drawn)], axis=1)
            right += sum(
                everything[drawn[k]][1] == everything[i][1] for k, i in zip(nearest, mine, strict=True)
            )
            total += len(mine)
    return right, total


def _all_costs(
    players: Mapping[str, Examples], everything: Sequence[tuple[str, str, int]]
) -> NDArray[np.float64]:
    """Return the (n, n) costs of each example against each."""
    moves = Moves(next(iter(players.values())).skeleton)
    for who, name, k in everything:
        moves.add(name, players[who].shown[name][k], players[who].fps[name][k])
    return np.array(
        [moves.costs(players[who].shown[name][k], players[who].fps[name][k]) for who, name, k in everything]
    )


def kinds_found(players: Mapping[str, Examples]) -> tuple[float, float]:
    """Return means over players: kinds found among the examples without their names, and the adjusted Rand index."""
    counts, indices = [], []
    for own in players.values():
        moves = own.moves(slice(None))
        truth = [example.name for example in moves.examples]
        kinds = moves.kinds()
        labels = {place: k for k, kind in enumerate(kinds) for place in kind}
        counts.append(len(kinds))
        indices.append(adjusted_rand(truth, [labels[i] for i in range(len(truth))]))
    return float(np.mean(counts)), float(np.mean(indices))


def adjusted_rand(one: Sequence[object], other: Sequence[object]) -> float:
    """Return the adjusted Rand index of two groupings: 1 for the same, 0 as by chance.

    Example:
        >>> adjusted_rand("aabb", [1, 1, 2, 2]), round(adjusted_rand("aabb", [1, 2, 1, 2]), 6)
        (1.0, -0.5)
    """

    def pairs(counts: "Counter[object]") -> int:
        return sum(count * (count - 1) // 2 for count in counts.values())

    both = pairs(Counter(zip(one, other, strict=True)))
    first, second = pairs(Counter(one)), pairs(Counter(other))
    expected = first * second / max(1, len(one) * (len(one) - 1) // 2)
    most = (first + second) / 2
    return 1.0 if most == expected else (both - expected) / (most - expected)
