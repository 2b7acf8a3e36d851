"""How often a move is said that nobody asked for, with the examples of one player at a time, in recordings of others.

    python -m checks.false_moves EXAMPLES LABELLED

EXAMPLES is a folder as for `mossar evaluate`, with an archive of segmented examples for each player; LABELLED holds
labelled recordings of other people doing other things. All that is confirmed counts. What is said in recordings of punches
and kicks (`FIGHTS`) is told apart, because there it may well be right: their labels say that there are such moves, and
not when which. Recordings that lack joints which the examples need are refused, and left out of the minutes.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import msgspec

from mossar_stream import FrameError, MoveEvent, Moves, Segmenter, Settings, Skeleton
from mossar_tools.console import Console
from mossar_tools.evaluation.sessions import (
    Examples,
    load_examples,
    load_session,
    sample_files,
    session_labels,
)
from mossar_tools.evaluation.takes import Take, load_folder

FIGHTS = ("precog/", "86_01")
MOST = 1.0  # in 10 minutes
EACH = 2  # examples of a move


class Player(msgspec.Struct, frozen=True):
    """What is said with the examples of one player.

    Args:
        name: Of the player.
        seconds: Of recordings that have the joints.
        refused: Recordings that have not.
        said: Recording and move, each time that one is confirmed.
    """

    name: str
    seconds: float
    refused: int
    said: list[tuple[str, str]]

    @property
    def in_ten_minutes(self) -> float:
        """How often something is said, all told."""
        return 600 * len(self.said) / max(self.seconds, 1e-9)


def confirmed(take: Take, moves: Moves) -> list[str]:
    """Return the moves that are confirmed in a recording.

    Raises:
        FrameError: If it lacks joints that the examples need.
    """
    segmenter = Segmenter(take.skeleton, Settings(), fps=take.fps, moves=moves)
    events = [*segmenter.push(take.positions, take.times), *segmenter.end_take()]
    return [event.name for event in events if isinstance(event, MoveEvent) and event.status == "confirmed"]


def count(name: str, examples: Examples, takes: Sequence[Take]) -> Player:
    """Return what is said with the examples of a player."""
    moves = examples.moves(slice(EACH))
    said: list[tuple[str, str]] = []
    seconds, refused = 0.0, 0
    for take in takes:
        try:
            said += [(take.name, move) for move in confirmed(take, moves)]
            seconds += take.duration
        except FrameError:
            refused += 1
    return Player(name, seconds, refused, said)


def line_of(player: Player) -> str:
    """Return a line of the table."""
    fights = sum(take.startswith(FIGHTS) for take, _ in player.said)
    what = ", ".join(f"{move} in {take} {n}" for (take, move), n in Counter(player.said).most_common(6))
    return f"{player.name:<10}{player.seconds / 60:>8.1f}{len(player.said):>7}{fights:>9}{player.in_ten_minutes:>12.2f}  {what}"


def skeleton_of(folder: Path) -> Skeleton | None:
    """Return the skeleton of the sessions beside the examples, if there are any."""
    labels = session_labels(folder)
    return load_session(labels[0]).skeleton if labels else None


def main() -> None:
    """Run the program; the exit status is 1 if something is said too often."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("examples", type=Path)
    parser.add_argument("labelled", type=Path)
    given = parser.parse_args()
    console = Console(sys.stdout, sys.stderr)
    takes = load_folder(given.labelled, console.status)
    skeleton = skeleton_of(given.examples)
    console.line(f"{'player':<10}{'minutes':>8}{'said':>7}{'fights':>9}{'in 10 min':>12}")
    players = []
    for path in sample_files(given.examples):
        players.append(count(path.stem, load_examples(path, skeleton), takes))
        console.line(line_of(players[-1]))
    worst = max((player.in_ten_minutes for player in players), default=0.0)
    refused = max((player.refused for player in players), default=0)
    console.line(
        f"most in 10 minutes: {worst:.2f} (at most {MOST:g}); {refused} of {len(takes)} recordings lack joints"
    )
    sys.exit(1 if worst > MOST else 0)


if __name__ == "__main__":
    main()
