"""Rate of false moves, with the examples of one player at a time, in recordings of others.

    python -m checks.false_moves EXAMPLES LABELLED

EXAMPLES is a folder as for `mossar evaluate`, with an archive of segmented examples for each player; LABELLED holds
labelled recordings of other people doing other things. Every confirmed move counts. Moves in recordings of punches and
kicks (`FIGHTS`) are reported apart, because they may well be right: the labels contain such moves, but not their times.
The same holds for exercises of UI-PRMD that are the same movement as a move (`ALIKE`): a deep squat is a duck, a straight
leg raise a kick. Those do not count for the limit. With `--as-shown` only moves count that face as they were shown.
Recordings that lack joints which the examples need are refused, and left out of the minutes.
"""

import argparse
import re
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import msgspec

from mossar_stream import Facing, FrameError, MoveEvent, Moves, Segmenter, Settings, Skeleton
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
# Exercises of UI-PRMD, files mNN_sNN: squat, hurdle step, side lunge, sit to stand, leg raise, and an arm raised sideways
# and in the plane of the shoulder blade.
ALIKE = {
    "m01": ("duck",),
    "m02": ("kick_left", "kick_right", "sidekick_left", "sidekick_right"),
    "m04": ("duck",),
    "m05": ("duck",),
    "m06": ("kick_left", "kick_right"),
    "m07": ("uppercut_left", "uppercut_right"),
    "m10": ("uppercut_left", "uppercut_right"),
}
MOST = 1.0  # in 10 minutes
EACH = 2  # examples of a move


class Player(msgspec.Struct, frozen=True):
    """Moves that are reported with the examples of one player.

    Args:
        name: Of the player.
        seconds: Of recordings that have the joints.
        refused: Recordings that lack them.
        said: Recording and move of each confirmation.
    """

    name: str
    seconds: float
    refused: int
    said: list[tuple[str, str]]

    @property
    def alike(self) -> int:
        """Number of exercises that are the same movement as a move, and were reported as it."""
        return sum(move in ALIKE.get(exercise_of(take), ()) for take, move in self.said)

    @property
    def in_ten_minutes(self) -> float:
        """Rate of other false moves."""
        return 600 * (len(self.said) - self.alike) / max(self.seconds, 1e-9)


def exercise_of(take: str) -> str:
    """Return the exercise of a recording of UI-PRMD; empty for others.

    Example:
        >>> exercise_of("ui_prmd/m05_s01"), exercise_of("precog/Seq1_5")
        ('m05', '')
    """
    found = re.fullmatch(r"(.*/)?(m\d\d)_s\d\d", take)
    return found[2] if found else ""


def confirmed(take: Take, moves: Moves) -> list[str]:
    """Return the moves that are confirmed in a recording.

    Raises:
        FrameError: If it lacks joints that the examples need.
    """
    segmenter = Segmenter(take.skeleton, Settings(), fps=take.fps, moves=moves)
    events = [*segmenter.push(take.positions, take.times), *segmenter.end_take()]
    return [event.name for event in events if isinstance(event, MoveEvent) and event.status == "confirmed"]


def count(name: str, examples: Examples, takes: Sequence[Take], facing: Facing = "any") -> Player:
    """Return the moves that are reported with the examples of a player."""
    moves = examples.moves(slice(EACH))
    moves.facing = facing
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
    return f"{player.name:<10}{player.seconds / 60:>8.1f}{len(player.said):>7}{fights:>9}{player.alike:>7}{player.in_ten_minutes:>12.2f}  {what}"


def skeleton_of(folder: Path) -> Skeleton | None:
    """Return the skeleton of the sessions beside the examples, if there are any."""
    labels = session_labels(folder)
    return load_session(labels[0]).skeleton if labels else None


def main() -> None:
    """Run the program; the exit status is 1 if there are too many false moves."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("examples", type=Path)
    parser.add_argument("labelled", type=Path)
    parser.add_argument("--as-shown", action="store_true")
    given = parser.parse_args()
    facing: Facing = "as_shown" if given.as_shown else "any"
    console = Console(sys.stdout, sys.stderr)
    takes = load_folder(given.labelled, console.status)
    skeleton = skeleton_of(given.examples)
    console.line(f"{'player':<10}{'minutes':>8}{'said':>7}{'fights':>9}{'alike':>7}{'in 10 min':>12}")
    players = []
    for path in sample_files(given.examples):
        players.append(count(path.stem, load_examples(path, skeleton), takes, facing))
        console.line(line_of(players[-1]))
    worst = max((player.in_ten_minutes for player in players), default=0.0)
    refused = max((player.refused for player in players), default=0)
    console.line(
        f"most in 10 minutes: {worst:.2f} (at most {MOST:g}); {refused} of {len(takes)} recordings lack joints"
    )
    sys.exit(1 if worst > MOST else 0)


if __name__ == "__main__":
    main()
