"""Stream: the frames and true cuts of one performer, block by block, in bounded memory."""

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Final

import msgspec
import numpy as np

from mossar_adapters.demo.body import CHANNEL, Floats, joint_positions
from mossar_adapters.demo.plan import Beat, beats, default_moves, parse_move
from mossar_adapters.demo.script import Stance
from mossar_adapters.demo.sensor import Sensor
from mossar_adapters.demo.strokes import Stroke
from mossar_adapters.demo.style import Style
from mossar_stream import Frames, SettingsError, performer_name

BLOCK: Final = 256  # frames computed at once

_BREATHS: Final = 0.25  # Hz
_BREATHING: Final = 0.002  # rad of the torso: the head moves by about a millimetre


class Cut(msgspec.Struct, frozen=True):
    """The middle of the change of posture between two moves.

    Args:
        time: Seconds from the start of the performance.
        frame: Number of the first delivered frame at or after `time`.
        before: Name of the move that ends.
        after: Name of the move that begins.
        kind: `pause`: the performer pauses for 0.1-0.2 s around the change of posture. `flow`: it does not.
            `rest`: one of the two is a rest (or stand).
    """

    time: float
    frame: int
    before: str
    after: str
    kind: str


def stream(
    seed: int,
    style: Style,
    *,
    moves: Sequence[str] | None = None,
    most_moves: int | None = None,
    seconds: float | None = None,
    performer: str = "p1",
    place: tuple[float, float] = (0.0, 0.0),
) -> Iterator[tuple[Frames, tuple[Cut, ...]]]:
    """Return an iterator over a performance: frames in blocks, with the cuts that lie in each.

    Args:
        seed: 0 or more.
        style: Rate, tempo and sensor.
        moves: See `performance`; None for default moves without end.
        most_moves: At most so many moves.
        seconds: Where to stop; None for the end of the moves.
        performer: Name.
        place: Place at which the performer starts, x and z in metres.

    Raises:
        SettingsError: If a move is unknown, the seed negative or the length not positive.
    """
    if seed < 0:
        raise SettingsError(f"seed must be 0 or more, not {seed}")
    if seconds is not None and not 0 < seconds < math.inf:
        raise SettingsError(f"seconds must be a positive number, not {seconds:g}")
    if moves is not None and not moves:
        raise SettingsError("moves must name at least one move")
    # Motion and sensor draw from generators of their own: noise does not change the performer's motion.
    rng = np.random.Generator(np.random.PCG64([seed, 0]))
    asked = None if moves is None else [parse_move(move) for move in moves]
    requests = itertools.islice(default_moves(rng) if asked is None else iter(asked), most_moves)
    home = Stance(*place)
    performed = _performed(beats(requests, rng, home, style.tempo), home, style.fps)
    return _delivered(performed, Sensor(seed, style), seconds, performer_name(performer))


def _performed(beats: Iterator[Beat], home: Stance, fps: float) -> Iterator[tuple[Floats, Floats, list[Cut]]]:
    """Yield true positions (n, J, 3), times (n,) and cuts (frame still open), n from 1 to `BLOCK`."""
    base, active, done = home.at_ease(), list[Stroke](), 0
    before, cuts = Beat("", 0.0, 0.0, (), None, ""), list[Cut]()
    for beat in itertools.chain(beats, [None]):
        if beat is not None and beat.cut is not None:
            cuts.append(Cut(beat.cut, -1, before.name, beat.name, beat.cut_kind))
        # Strokes still unknown begin no earlier than the next move: up to there frames can be computed.
        last = math.ceil((before.end if beat is None else beat.start) * fps - 1e-9)
        for first in range(done, last, BLOCK):
            times = np.arange(first, min(first + BLOCK, last), dtype=np.float64) / fps
            yield joint_positions(_poses(base, active, times)), times, cuts
            cuts = []
        done = max(done, last)
        for stroke in [stroke for stroke in active if stroke.end < done / fps]:
            base = base + stroke.amount * stroke.lasting
            active.remove(stroke)
        if beat is not None:
            active += beat.strokes
            before = beat


def _poses(base: Floats, active: list[Stroke], times: Floats) -> Floats:
    """Return the poses (n, C) at `times`: the sum of all strokes, and the breath."""
    poses = np.tile(base, (len(times), 1))
    for stroke in active:
        poses += stroke.at(times)
    poses[:, CHANNEL["torso_pitch"]] += _BREATHING * np.sin(2 * np.pi * _BREATHS * times)
    return poses


def _delivered(
    performed: Iterator[tuple[Floats, Floats, list[Cut]]],
    sensor: Sensor,
    seconds: float | None,
    performer: str,
) -> Iterator[tuple[Frames, tuple[Cut, ...]]]:
    """Yield the frames of the blocks that arrive, numbered, up to `seconds`; cuts come with their frame."""
    end = math.inf if seconds is None else seconds
    count, waiting = 0, list[Cut]()
    for positions, times, cuts in performed:
        waiting += cuts
        if times[0] >= end:
            return
        positions, times = sensor.sense(positions, times)
        positions, times = positions[times < end], times[times < end]
        if len(times) == 0:
            continue
        passed = [cut for cut in waiting if cut.time <= times[-1]]
        waiting = waiting[len(passed) :]
        numbers = count + np.searchsorted(times, [cut.time for cut in passed])
        numbered = (msgspec.structs.replace(c, frame=int(n)) for c, n in zip(passed, numbers, strict=True))
        # Whole micrometres hide the last bits in which sine and cosine differ between processors.
        rounded = np.round(positions, 6).astype(np.float32)
        yield Frames(rounded, times, performer=performer, first_frame=count), tuple(numbered)
        count += len(times)
