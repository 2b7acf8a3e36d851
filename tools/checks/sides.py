"""Sides: moves on command as if the sensor stood elsewhere, or as if the player turned meanwhile.

    python -m checks.sides DIR

Scores sessions of moves on command as `mossar evaluate DIR` does: as recorded, turned about the vertical through the player
at once or steadily, and with the examples of one side mirrored for the other.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import Moves, Settings
from mossar_tools.evaluation.moves_report import COLUMNS, score_line
from mossar_tools.evaluation.recognising import Outcome, confirmed, judge, side_of, summary
from mossar_tools.evaluation.sessions import Session, load_sessions

SWAY, SWAY_PERIOD = 60.0, 8.0  # degrees to either side, s
SHOWN_SIDE = "left"  # whose examples are mirrored

Angle = Callable[[NDArray[np.float64]], NDArray[np.float64]]  # s to degrees


def _by(degrees: float) -> Angle:
    return lambda times: np.full(len(times), degrees)


def _turning(speed: float) -> Angle:
    return lambda times: speed * times


def _swaying(times: NDArray[np.float64]) -> NDArray[np.float64]:
    return SWAY * np.sin(2.0 * np.pi * times / SWAY_PERIOD)


ANGLES: dict[str, Angle] = {
    **{f"turned by {degrees:g} degrees": _by(degrees) for degrees in (30.0, 90.0, 180.0)},
    **{f"turning, {speed:g} degrees/s": _turning(speed) for speed in (10.0, 20.0, 45.0, 90.0)},
    f"swaying, {SWAY:g} degrees, {SWAY_PERIOD:g} s": _swaying,
}


def turned(session: Session, angle: Angle) -> Session:
    """Return a session whose player is turned about the vertical (y) through the own centre; the path turns as well."""
    radians = np.radians(angle(session.times - session.times[0]))
    positions = session.positions.astype(np.float64)
    root = session.skeleton.root
    centre = positions[:, root] if root >= 0 else np.nanmean(positions, axis=1)
    steps = _rotated(np.diff(centre, axis=0, prepend=centre[:1]), radians)
    path = centre[0] + np.cumsum(np.nan_to_num(steps), axis=0)
    placed = path[:, None] + _rotated(positions - centre[:, None], radians[:, None])
    return msgspec.structs.replace(session, positions=placed.astype(np.float32))


def _rotated(vectors: NDArray[np.float64], radians: NDArray[np.float64]) -> NDArray[np.float64]:
    cosine, sine = np.cos(radians), np.sin(radians)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([cosine * x + sine * z, y, cosine * z - sine * x], axis=-1)


def mirrored(session: Session) -> Moves:
    """Return the examples of a session without those of the right side, which are the mirror images of the left ones."""
    moves = session.examples.moves(slice(None))
    for name in moves.names:
        if side_of(name) == SHOWN_SIDE:
            moves.set_rule(name, mirrored=True)
        elif side_of(name) is not None:
            moves.remove(name)
    return moves


def views(sessions: Sequence[Session], settings: Settings) -> Iterator[tuple[str, list[Outcome]]]:
    """Yield the name of each view, and the outcome of each session from there.

    Args:
        sessions: As they were recorded.
        settings: Of the segmenters.
    """
    for name, angle in {"as recorded": _by(0.0), **ANGLES}.items():
        yield (
            name,
            [_judged(session, turned(session, angle), _shown(session), settings) for session in sessions],
        )
    if any(side_of(move) for session in sessions for move in session.examples.shown):
        found = [_judged(session, session, mirrored(session), settings) for session in sessions]
        yield f"{SHOWN_SIDE} shown, mirrored", found


def _shown(session: Session) -> Moves:
    return session.examples.moves(slice(None))


def _judged(session: Session, seen: Session, moves: Moves, settings: Settings) -> Outcome:
    return judge(session, confirmed(seen, moves, settings))


def main() -> int:
    """Print the table of the folder that the command line names; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", metavar="DIR", type=Path, help="sessions of moves on command")
    sessions = load_sessions(parser.parse_args().folder, lambda _: None)
    if not sessions:
        print("the folder holds no sessions of moves on command", file=sys.stderr)
        return 2
    print(f"{'view':<24}{COLUMNS}")
    for name, outcomes in views(sessions, Settings()):
        print(score_line(name, summary(outcomes)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
