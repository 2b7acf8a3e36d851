"""Turning: sessions as if the sensor stood elsewhere, or as if the player turned meanwhile; examples of one side mirrored."""

from collections.abc import Callable, Iterator, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import Moves, Settings
from mossar_tools.evaluation.recognising import Outcome, Summary, confirmed, judge, side_of, summary
from mossar_tools.evaluation.sessions import Session

SWAY, SWAY_PERIOD = 60.0, 8.0  # degrees to either side, s
SHOWN_SIDE = "left"  # whose examples are mirrored

Angle = Callable[[NDArray[np.float64]], NDArray[np.float64]]  # s to degrees


class View(msgspec.Struct, frozen=True):
    """What came of all sessions from one view.

    Args:
        name: For the table.
        outcomes: Of each session.
        scores: Of all together.
    """

    name: str
    outcomes: list[Outcome]
    scores: Summary


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


def views(
    sessions: Sequence[Session], settings: Settings, on_progress: Callable[[str], None]
) -> Iterator[View]:
    """Yield what comes of sessions that are turned, and with the examples of one side mirrored.

    Args:
        sessions: As they were recorded.
        settings: Of the segmenters.
        on_progress: Gets a line before each step.
    """
    for name, angle in ANGLES.items():
        on_progress(name)
        yield _view(
            name,
            [
                judge(
                    session, confirmed(turned(session, angle), session.examples.moves(slice(None)), settings)
                )
                for session in sessions
            ],
        )
    if any(side_of(move) for session in sessions for move in session.examples.shown):
        on_progress("mirrored")
        found = [judge(session, confirmed(session, mirrored(session), settings)) for session in sessions]
        yield _view(f"{SHOWN_SIDE} shown, mirrored", found)


def _view(name: str, outcomes: list[Outcome]) -> View:
    return View(name, outcomes, summary(outcomes))
