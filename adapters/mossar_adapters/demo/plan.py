"""Plan: which moves a performer does, when each begins and ends, and where the true cuts lie."""

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Final

import msgspec
import numpy as np

from mossar_adapters.demo.body import Floats
from mossar_adapters.demo.change import change
from mossar_adapters.demo.moves import jump, kick, punch, squat, wave
from mossar_adapters.demo.postures import posture
from mossar_adapters.demo.script import Script, Stance
from mossar_adapters.demo.steps import turn, walk
from mossar_adapters.demo.strokes import Stroke
from mossar_stream import SettingsError

Write = Callable[[Script, str, float, int], Stance]

# The writer of a move's strokes, and its least and most repetitions.
REPEATED: Final[dict[str, tuple[Write, int, int]]] = {
    "walk": (walk, 4, 5),
    "punch": (punch, 5, 6),
    "kick": (kick, 4, 4),
    "jump": (jump, 3, 3),
    "wave": (wave, 4, 5),
    "squat": (squat, 2, 2),
    "turn": (turn, 6, 6),
}
STILL: Final = ("rest", "stand")
SIDED: Final = ("punch", "kick", "wave", "turn")
MOVES: Final = ("rest", *REPEATED, "stand")

FIRST_ROUND: Final = 17  # default moves from the first rest to the second-next, with all kinds
STAND_SECONDS: Final = 20.0
LONGEST_STILL: Final = 86400.0  # s
FLOWING: Final = 0.7  # share of changes without a pause
_TURNS: Final = (math.radians(45), math.radians(70))
_PACES: Final = (0.82, 1.0)  # factor on the times of a move
_SIZES: Final = (0.88, 1.1)
_RESTS: Final = (1.5, 2.5)  # s
_CHANGES: Final = (0.25, 0.3)  # s
_PAUSES: Final = (0.1, 0.2)  # s
_HOLD: Final = 0.07  # s at pace 1 that a move ends in its posture, still
_FAR: Final = 0.8  # m from its place, from where on a performer turns back


class MoveRequest(msgspec.Struct, frozen=True):
    """A request for a move.

    Args:
        kind: One of `MOVES`.
        side: "left" or "right", or "" to leave it open.
        seconds: How long to be still, for rest and stand only; None to leave it open.
    """

    kind: str
    side: str = ""
    seconds: float | None = None


class Beat(msgspec.Struct, frozen=True):
    """A move at its time.

    Args:
        name: The move, with its side: `punch_left`, `rest`.
        start: Seconds from the start of the performance to the change of posture that leads to it.
        end: Seconds to the end of its last motion.
        strokes: The motion, the change included.
        cut: Seconds to the true cut before it; None if there is none.
        cut_kind: `pause`, `flow` or `rest`; empty without a cut.
    """

    name: str
    start: float
    end: float
    strokes: tuple[Stroke, ...]
    cut: float | None
    cut_kind: str


def parse_move(text: str) -> MoveRequest:
    """Return the move written as `punch`, `punch_left`, `rest` or `stand:20` (seconds).

    Raises:
        SettingsError: If there is no such move, or it has no side or no length to choose.
    """
    name, colon, length = text.strip().partition(":")
    kind, underscore, side = name.partition("_")
    if kind not in MOVES:
        raise SettingsError(f"no move is called {text[:40]!r}; there are {', '.join(MOVES)}")
    if underscore and (kind not in SIDED or side not in {"left", "right"}):
        sided = ", ".join(f"{move}_left, {move}_right" for move in SIDED)
        raise SettingsError(f"move {text[:40]!r}: sides can be chosen as {sided}")
    if not colon:
        return MoveRequest(kind, side)
    try:
        seconds = float(length)
    except ValueError:
        seconds = math.nan
    if kind not in STILL or not 0 < seconds <= LONGEST_STILL:
        raise SettingsError(
            f"move {text[:40]!r}: only rest and stand have a length, in seconds from 0 to {LONGEST_STILL:g}"
        )
    return MoveRequest(kind, side, seconds)


def default_moves(rng: np.random.Generator) -> Iterator[MoveRequest]:
    """Yield moves without end, in rounds of about 43 s that have every kind; `stand` is left out.

    No kind follows itself, and walk and turn alternate without touching: a turn is where a performer can head
    back to its place.
    """
    yield MoveRequest("rest")
    kinds = ["punch", "kick", "jump", "wave", "squat"] * 2 + ["turn", "walk"] * 2
    while True:
        order = [kinds[i] for i in rng.permutation(len(kinds))]
        turns = itertools.cycle(("turn", "walk"))
        order = [next(turns) if kind in {"turn", "walk"} else kind for kind in order]
        order.insert(len(order) // 2, "rest")
        if all({*pair} - {"turn", "walk"} and pair[0] != pair[1] for pair in itertools.pairwise(order)):
            yield from (MoveRequest(kind) for kind in (*order, "rest"))


def beats(
    moves: Iterator[MoveRequest], rng: np.random.Generator, place: Stance, tempo: float = 1.0
) -> Iterator[Beat]:
    """Yield the moves at their times, with the true cuts between them.

    A move is repeated for 1.5-3 s in its own posture; rest and stand are moves without motion. Between two moves
    the performer changes posture in one brisk movement of 0.25-0.3 s, whose middle is the cut. It pauses for
    0.1-0.2 s, half before and half after it (`pause`), or goes straight on (`flow`); next to rest and stand the
    cut is called `rest`. Between two of these there is neither change nor cut.

    Args:
        moves: The moves.
        rng: Chooses sizes and pauses that the moves leave open.
        place: Place at which the performer starts, and stays near.
        tempo: 2 is twice as fast, jumps excepted.

    Yields:
        Beats, their starts in increasing order.
    """
    stance, held = place, posture("stand", "l")
    before: Beat | None = None
    for move in moves:
        side = move.side[:1] or "lr"[rng.integers(2)]
        angle = rng.uniform(*_TURNS)
        if move.kind == "turn" and not move.side:
            side, angle = _homewards(stance, place, side, angle)
        goal = posture(move.kind, side)
        begin, cut, kind, strokes = _change(before, move, rng, tempo, (stance, held, goal))
        script = Script(stance, begin, rng.uniform(*_PACES) / tempo, goal)
        if move.kind in STILL:
            length = STAND_SECONDS if move.kind == "stand" else rng.uniform(*_RESTS)
            end = begin + (move.seconds or length)
        else:
            write, fewest, most = REPEATED[move.kind]
            size = angle if move.kind == "turn" else rng.uniform(*_SIZES)
            stance = write(script, side, size, int(rng.integers(fewest, most + 1)))
            end = script.end + _HOLD * script.pace
        start = min([stroke.start for stroke in strokes], default=begin)
        before = Beat(_name(move.kind, side), start, end, (*strokes, *script.strokes), cut, kind)
        held = goal
        yield before


def _change(
    before: Beat | None,
    move: MoveRequest,
    rng: np.random.Generator,
    tempo: float,
    postures: tuple[Stance, Floats, Floats],
) -> tuple[float, float | None, str, list[Stroke]]:
    """Return the begin of the next move, the cut before it with its kind, and the change that leads to it.

    Args:
        before: The move before.
        move: The next move.
        rng: Chooses the durations of change and pause.
        tempo: 2 is twice as fast.
        postures: Where the performer stands, the posture it holds and the one to come.
    """
    stance, held, goal = postures
    seconds = rng.uniform(*_CHANGES) / tempo
    pause = rng.uniform(*_PAUSES) / tempo if rng.random() >= FLOWING else 0.0
    end, quiet = (0.0, True) if before is None else (before.end, before.name in STILL)
    if quiet and move.kind in STILL:
        return end, None, "", []
    rests = quiet or move.kind in STILL
    start = end if rests else end + pause / 2
    script = Script(stance, start, 1.0, held)
    change(script, goal, seconds)
    begin = start + seconds if rests else start + seconds + pause / 2
    if before is None:
        return begin, None, "", script.strokes
    return begin, start + seconds / 2, "rest" if rests else "pause" if pause else "flow", script.strokes


def _name(kind: str, side: str) -> str:
    """Return the name of a move, with its side where it has one."""
    return f"{kind}_{'left' if side == 'l' else 'right'}" if kind in SIDED else kind


def _homewards(stance: Stance, place: Stance, side: str, angle: float) -> tuple[str, float]:
    """Return side and angle of a turn towards the performer's place if that is far, else as given."""
    x, z = place.x - stance.x, place.z - stance.z
    if math.hypot(x, z) < _FAR:
        return side, angle
    bearing = (math.atan2(x, z) - stance.heading + math.pi) % math.tau - math.pi
    return "l" if bearing > 0 else "r", min(max(abs(bearing), _TURNS[0]), _TURNS[1])
