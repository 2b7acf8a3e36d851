"""Moves report: results of sessions and of segmented examples, as tables and as one JSON object."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from mossar_stream import MossarError, Settings
from mossar_tools.evaluation.recognising import (
    DRAWS,
    Outcome,
    Summary,
    by_move,
    confirmed,
    judge,
    kinds_found,
    other_people,
    summary,
)
from mossar_tools.evaluation.sessions import (
    Examples,
    Session,
    load_examples,
    load_sessions,
    sample_files,
    session_labels,
)

EACH = (1, 2)  # examples of each move drawn from other people
SINGLES = 3  # first examples, each tried alone

COLUMNS = f"{'recall':>8}{'precision':>11}{'F1':>8}{'delay 10 %':>12}{'median':>9}{'90 %':>9}{'side':>14}"
NOTES = """a first right answer within a command is a hit, every other answer a false one, by confirmed moves; of two commands of
the same move in a row the first does not count; delay: after the peak of speed within the command;
side: hits of moves that are called left or right with a limb of that side"""


class Choice(msgspec.Struct, frozen=True):
    """The results of all sessions with some of the examples.

    Args:
        examples: Name of the chosen examples of each move.
        outcomes: Results of each session.
        scores: Scores of all sessions together.
    """

    examples: str
    outcomes: list[Outcome]
    scores: Summary


class MovesResult(msgspec.Struct, frozen=True):
    """The content of the report.

    Args:
        seconds: Duration of all sessions, s.
        choices: Results for each choice of examples.
        people: Number of people who showed segmented examples.
        told: Share of examples recognised by other people's, for each number of examples; see `other_people`.
        kinds: Kinds found without names, moves, and the adjusted Rand index, means over people; None without examples.
    """

    seconds: float
    choices: list[Choice]
    people: int
    told: dict[int, float]
    kinds: tuple[float, float, float] | None


def is_of_moves(folder: Path) -> bool:
    """Return whether a folder holds sessions or segmented examples."""
    return bool(session_labels(folder) or sample_files(folder))


def evaluate_moves(
    folder: Path,
    settings: Settings,
    on_progress: Callable[[str], None],
    *,
    strict: float | None = None,
) -> MovesResult:
    """Score the sessions and the examples of a folder.

    Args:
        folder: See `sessions`.
        settings: Of the segmenters.
        on_progress: Gets a line before each step.
        strict: Strictness of all moves in the sessions as they were recorded; None for the usual.

    Raises:
        MossarError: If a file cannot be used.
    """
    sessions = load_sessions(folder, lambda path: on_progress(f"reading {path}"))
    choices = []
    for name, chosen in _choices(sessions):
        outcomes = []
        for session in sessions:
            on_progress(f"{session.name}, {name}")
            moves = session.examples.moves(chosen)
            for move in moves.names:
                moves.set_rule(move, strict=strict)
            outcomes.append(judge(session, confirmed(session, moves, settings)))
        choices.append(Choice(name, outcomes, summary(outcomes)))
    skeleton = sessions[0].skeleton if sessions else None
    players = {path.stem: load_examples(path, skeleton) for path in sample_files(folder)}
    seconds = sum(float(session.times[-1] - session.times[0]) for session in sessions)
    if len(players) < 2:  # no other people
        return MovesResult(seconds, choices, 0, {}, None)
    if len({own.skeleton for own in players.values()}) > 1:
        raise MossarError(f"{folder}: the players' examples have different joints; they cannot be compared")
    on_progress("segmented examples")
    return MovesResult(seconds, choices, len(players), *_segmented(players))


def _choices(sessions: Sequence[Session]) -> list[tuple[str, slice]]:
    most = max((session.examples.most for session in sessions), default=0)
    if most == 0:
        return []
    singles = [(f"one, number {k + 1}", slice(k, k + 1)) for k in range(min(most, SINGLES)) if most > 1]
    return [("all, at most two" if most == 2 else f"all, at most {most}", slice(None)), *singles]


def _segmented(players: Mapping[str, Examples]) -> tuple[dict[int, float], tuple[float, float, float]]:
    told = {}
    for each in EACH:
        right, total = other_people(players, each)
        told[each] = right / max(1, total)
    moves = sum(len(own.shown) for own in players.values()) / len(players)
    count, index = kinds_found(players)
    return told, (count, moves, index)


def moves_lines(found: MovesResult) -> Iterator[str]:
    """Yield the lines of the tables."""
    if found.choices:
        first = found.choices[0]
        commands = sum(len(one.hits) + len(one.missed) for one in first.outcomes)
        yield f"{len(first.outcomes)} sessions, {found.seconds:.0f} s, {commands} moves on command, each player's own examples"
        yield f"{'examples of each move':<24}{COLUMNS}"
        yield from (score_line(choice.examples, choice.scores) for choice in found.choices)
        yield ""
        yield f"by move, {first.examples}"
        yield f"{'move':<24}{'hit':>8}{'missed':>11}  taken for"
        for move, counts in by_move(first.outcomes).items():
            taken = ", ".join(f"{name[3:]} {n}" for name, n in counts.most_common() if name.startswith("as "))
            yield f"{move[:23]:<24}{counts['hit']:>8}{counts['missed']:>11}  {taken}".rstrip()
        yield ""
        yield NOTES
    if found.kinds is not None:
        yield ""
        yield f"segmented examples of {found.people} people, recognised by other people's, drawn {DRAWS} times"
        for each, share in found.told.items():
            yield f"{f'{each} of each move':<24}{100 * share:>7.1f} %"
        kinds, moves, index = found.kinds
        yield f"kinds found without names, each person: {kinds:.1f} of {moves:.0f} moves; adjusted Rand index {index:.3f}"


def score_line(name: str, scores: Summary) -> str:
    """Return a line of the table, below `COLUMNS`."""
    delays = "".join(
        f"{delay:.2f} s".rjust(width) for delay, width in zip(scores.delays, (12, 9, 9), strict=True)
    )
    side = f"{scores.right_side} of {scores.sided}".rjust(14) if scores.sided else ""
    return f"{name:<24}{scores.recall:>8.3f}{scores.precision:>11.3f}{scores.f1:>8.3f}{delays}{side}"


def moves_json(found: MovesResult) -> dict[str, Any]:
    """Return the report as one JSON object."""
    content: dict[str, Any] = msgspec.to_builtins(found, str_keys=True)
    for choice, one in zip(found.choices, content["choices"], strict=True):
        one["by_move"] = {move: dict(counts) for move, counts in by_move(choice.outcomes).items()}
    return {"v": 1, **content}


def moves_rows(found: MovesResult) -> list[dict[str, Any]]:
    """Return a row for each choice of examples, and session."""
    return [
        {
            "examples": choice.examples,
            "session": outcome.session,
            **{
                name: value
                for name, value in msgspec.to_builtins(summary([outcome])).items()
                if name != "delays"
            },
            "median_delay_s": summary([outcome]).delays[1],
        }
        for choice in found.choices
        for outcome in choice.outcomes
    ]
