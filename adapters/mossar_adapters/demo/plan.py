"""Plan: which moves a performer does, when each begins and ends, and where the true cuts lie."""

import math
from collections.abc import Callable, Iterator
from typing import Final

import msgspec
import numpy as np

from mossar_adapters.demo.moves import jump, kick, punch, squat, wave
from mossar_adapters.demo.script import Script, Stance
from mossar_adapters.demo.steps import turn, walk
from mossar_adapters.demo.strokes import Stroke
from mossar_stream.errors import SettingsError

# Limb moves take a size (1 = full); their functions write the strokes.
SIZED: Final[dict[str, Callable[[Script, str, float], Stance]]] = {
    "punch": punch,
    "kick": kick,
    "jump": jump,
    "wave": wave,
    "squat": squat,
}
STILL: Final = ("rest", "stand")
SIDED: Final = ("punch", "kick", "wave", "turn")
MOVES: Final = ("rest", "walk", *SIZED, "turn", "stand")

FIRST_ROUND: Final = 18  # default moves from the first rest to the second-next, with all kinds
STAND_SECONDS: Final = 20.0
LONGEST_STILL: Final = 86400.0  # s
FLOWING: Final = 0.3  # share of neighbouring moves without a pause between
_FAR: Final = 0.8  # m from its place, from where on a performer turns back


class Wish(msgspec.Struct, frozen=True):
    """A move as asked for.

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
        start: Seconds from the start of the performance to its first motion.
        end: Seconds to the end of its last motion.
        strokes: The motion.
        cut: Seconds to the true cut before it; None if there is none.
        cut_kind: `pause`, `flow` or `rest`; empty without a cut.
    """

    name: str
    start: float
    end: float
    strokes: tuple[Stroke, ...]
    cut: float | None
    cut_kind: str


def parse_move(text: str) -> Wish:
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
        return Wish(kind, side)
    try:
        seconds = float(length)
    except ValueError:
        seconds = math.nan
    if kind not in STILL or not 0 < seconds <= LONGEST_STILL:
        raise SettingsError(
            f"move {text[:40]!r}: only rest and stand have a length, in seconds from 0 to {LONGEST_STILL:g}"
        )
    return Wish(kind, side, seconds)


def default_moves(rng: np.random.Generator) -> Iterator[Wish]:
    """Yield moves without end, in rounds of about 35 s that have every kind; `stand` is left out.

    Every walk follows a turn, because that is where a performer can head back to its place.
    """
    yield Wish("rest")
    groups = [("punch",)] * 3 + [("turn", "walk")] * 2
    groups += [(kind,) for kind in ("kick", "jump", "wave", "squat") for _ in range(2)]
    while True:
        order = [groups[i] for i in rng.permutation(len(groups))]
        order.insert(len(order) // 2, ("rest",))
        order.append(("rest",))
        yield from (Wish(kind) for group in order for kind in group)


def beats(
    wishes: Iterator[Wish], rng: np.random.Generator, place: Stance, tempo: float = 1.0
) -> Iterator[Beat]:
    """Yield the moves at their times, with the true cuts between them.

    Two moves are parted by a pause of 0.1-0.5 s (`pause`: the cut is its middle), or the second begins the
    moment the first has ended (`flow`: that moment is the cut). Rest and stand are moves of their own without
    motion: the cut lies where the motion before ends, and where the motion after begins (`rest`). Between two
    of them there is no cut.

    Args:
        wishes: The moves.
        rng: Chooses what the wishes leave open, sizes and pauses.
        place: Where the performer starts, and stays near.
        tempo: 2 is twice as fast, jumps excepted.

    Yields:
        Beats, their starts in increasing order.
    """
    stance = place
    before: Beat | None = None
    for wish in wishes:
        pace = rng.uniform(0.92, 1.15) / tempo
        start, cut, kind = _begin(before, wish, rng, tempo)
        script = Script(stance, start, pace)
        if wish.kind in STILL:
            length = STAND_SECONDS if wish.kind == "stand" else rng.uniform(1.2, 2.2)
            before = Beat(wish.kind, start, start + (wish.seconds or length), (), cut, kind)
        else:
            name, stance = _perform(wish, rng, script, place)
            before = Beat(name, start, script.end, tuple(script.strokes), cut, kind)
        yield before


def _begin(
    before: Beat | None, wish: Wish, rng: np.random.Generator, tempo: float
) -> tuple[float, float | None, str]:
    """Return start, cut and kind of cut of the next move."""
    flows, pause = rng.random() < FLOWING, rng.uniform(0.1, 0.5) / tempo
    if before is None:
        return 0.0, None, ""
    if not before.strokes and wish.kind in STILL:
        return before.end, None, ""
    if not before.strokes or wish.kind in STILL:
        return before.end, before.end, "rest"
    if flows:
        return before.end, before.end, "flow"
    return before.end + pause, before.end + pause / 2, "pause"


def _perform(wish: Wish, rng: np.random.Generator, script: Script, place: Stance) -> tuple[str, Stance]:
    """Write a move into `script`; return its name with the side, and the stance it ends in."""
    side, size = wish.side[:1] or "lr"[rng.integers(2)], rng.uniform(0.85, 1.1)
    if wish.kind == "walk":
        stance = walk(script, side, int(rng.integers(3, 6)))
    elif wish.kind == "turn":
        angle = rng.uniform(math.radians(70), math.radians(180))
        if not wish.side:
            side, angle = _homewards(script.stance, place, side, angle)
        stance = turn(script, side, angle)
    else:
        stance = SIZED[wish.kind](script, side, size)
    full = {"l": "left", "r": "right"}[side]
    return f"{wish.kind}_{full}" if wish.kind in SIDED else wish.kind, stance


def _homewards(stance: Stance, place: Stance, side: str, angle: float) -> tuple[str, float]:
    """Return side and angle of a turn that faces the performer's place if that is far, else as given."""
    x, z = place.x - stance.x, place.z - stance.z
    if math.hypot(x, z) < _FAR:
        return side, angle
    bearing = (math.atan2(x, z) - stance.heading + math.pi) % math.tau - math.pi
    return "l" if bearing > 0 else "r", max(abs(bearing), math.radians(60))
