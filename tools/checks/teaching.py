"""Whether live teaching takes each performance as one example, pauses included, and nothing else.

    python -m checks.teaching [EXAMPLES]

Each session is a rest, three performances and the rests between them, at 30 Hz. The moves are those of `MOVES`, made with the body
of the built-in performer, which sways; a sensor adds noise. EXAMPLES is a folder with an archive of clips for each player, as for
`mossar evaluate`: their first three clips of each move make a session, in which the performer goes from the end of a clip to
the beginning of the next one while resting. A performance begins and ends where a joint is farther from its first and last
pose than `FAR` of the farthest.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.demo.body import NEUTRAL, SKELETON, joint_positions, pose
from mossar_adapters.demo.moves import jump
from mossar_adapters.demo.script import Script, Stance
from mossar_adapters.demo.strokes import shaking
from mossar_adapters.source import Meta
from mossar_stream import Frames, Skeleton
from mossar_tools.console import Console
from mossar_tools.evaluation.sessions import load_examples, sample_files
from mossar_tools.taking import Movement, MovementTaker

FPS = 30.0
NOISES = (0.0, 0.003, 0.005, 0.008)  # m, of the sensor
NOISE_OF_CLIPS = 0.003  # m
SWAY = 0.006  # m
SEEDS = 2
EACH = 3  # performances of a session
RESTS = (2.0, 3.0)  # s
CHANGE = 0.8  # s, in which the performer goes from one pose at rest to another
FAR = 0.05
LEAST = 0.97  # share of right sessions

Floats = NDArray[np.float64]
Span = tuple[float, float]  # s


class Session(NamedTuple):
    """The session of a performer.

    Args:
        name: Of the move.
        skeleton: J joints.
        positions: (n, J, 3) m.
        true: Begin and end of each performance.
    """

    name: str
    skeleton: Skeleton
    positions: NDArray[np.float32]
    true: list[Span]


class Outcome(NamedTuple):
    """The examples taken in a session.

    Args:
        session: The session.
        taken: Begin and end of each movement.
    """

    session: Session
    taken: list[Span]

    @property
    def is_right(self) -> bool:
        """Whether each performance, and nothing else, was taken."""
        pairs = list(zip(self.taken, self.session.true, strict=False))
        return len(self.taken) == len(self.session.true) and all(
            min(one[1], other[1]) > max(one[0], other[0]) for one, other in pairs
        )

    def errors(self, end: int) -> list[float]:
        """Return the errors of begins (0) or ends (1), s."""
        return [abs(one[end] - other[end]) for one, other in zip(self.taken, self.session.true, strict=True)]


def wave(script: Script, pause: float, swings: float) -> None:
    """Raise an arm, swing the forearm four times, lower the arm."""
    begin, end = 0.5 + pause, 0.5 + pause + 4 * swings
    script.to(0.0, 0.5, l_azimuth=1.2, l_elevation=0.6, l_reach=0.42, l_swivel=-0.2)
    script.sway(begin, end, shaking(4), l_azimuth=-0.35, l_swivel=0.1)
    script.back(end + pause, end + pause + 0.5)


def hold(script: Script, seconds: float) -> None:
    """Raise an arm sideways and hold it."""
    script.to(0.0, 0.7, l_azimuth=1.3, l_elevation=0.1)
    script.back(0.7 + seconds, 1.4 + seconds)


def squat(script: Script, count: int, pause: float) -> None:
    """Squat, pausing below and between."""
    for k in range(count):
        begin = k * (1.6 + 2 * pause)
        script.to(begin, begin + 0.8, hips_y=0.58, hips_z=-0.17, hips_pitch=0.42, torso_pitch=0.33)
        script.back(begin + 0.8 + pause, begin + 1.6 + pause)


def kick(script: Script) -> None:
    """Kick forwards once."""
    script.to(0.0, 0.3, r_y=0.5, r_z=0.4, r_pitch=0.3)
    script.to(0.3, 0.55, r_y=0.9, r_z=0.92, r_pitch=-0.8)
    script.back(0.6, 1.1)


def punch(script: Script) -> None:
    """Strike straight ahead once."""
    script.to(0.0, 0.25, l_azimuth=0.2, l_elevation=0.1, torso_yaw=-0.4)
    script.back(0.25, 0.6)


def steps_up(script: Script) -> None:
    """Raise an arm in two steps."""
    script.to(0.0, 0.6, r_azimuth=0.2, r_elevation=0.0)
    script.to(1.2, 1.7, r_elevation=1.3)
    script.back(2.4, 3.1)


def slow(script: Script) -> None:
    """Raise an arm slowly."""
    script.to(0.0, 2.2, r_azimuth=1.3, r_elevation=1.0)
    script.back(2.2, 4.4)


def hops(script: Script) -> None:
    """Hop three times."""
    jump(script, "l", 1.0, 3)


MOVES: dict[str, Callable[[Script], object]] = {
    "wave": partial(wave, pause=0.0, swings=0.5),
    "wave with pauses": partial(wave, pause=0.6, swings=0.6),
    "slow wave": partial(wave, pause=0.2, swings=0.8),
    "arm held 1.5 s": partial(hold, seconds=1.5),
    "arm held 2.5 s": partial(hold, seconds=2.5),
    "squat": partial(squat, count=1, pause=0.0),
    "squat held 1 s": partial(squat, count=1, pause=1.0),
    "three squats": partial(squat, count=3, pause=0.0),
    "kick": kick,
    "punch": punch,
    "arm up in two steps": steps_up,
    "three hops": hops,
    "slow raise": slow,
}


def performed(move: Callable[[Script], object]) -> Floats:
    """Return a performance of the built-in performer, (n, J, 3) m."""
    script = Script(Stance(), 0.0, 1.0, pose(NEUTRAL))
    move(script)
    times = np.arange(0.0, script.end + 1 / FPS, 1 / FPS)
    poses = np.tile(Stance().at_ease(), (len(times), 1)) + sum(stroke.at(times) for stroke in script.strokes)
    return joint_positions(poses)


def session(
    name: str, skeleton: Skeleton, performances: Sequence[Floats], noise: float, rng: np.random.Generator
) -> Session:
    """Return performances with rests around them."""
    parts, true, count = [_rest(performances[0][0], performances[0][0], RESTS[0])], [], round(RESTS[0] * FPS)
    for k, shown in enumerate(performances):
        begin, end = _moving(shown)
        true.append(((count + begin) / FPS, (count + end) / FPS))
        following = performances[k + 1][0] if k + 1 < len(performances) else shown[-1]
        parts += [shown, _rest(shown[-1], following, rng.uniform(*RESTS))]
        count += len(shown) + len(parts[-1])
    positions = np.concatenate(parts)
    rates = rng.uniform(0.2, 0.9, positions.shape[1:])
    turns = rates * np.arange(len(positions))[:, None, None] / FPS + rng.uniform(0.0, 1.0, rates.shape)
    positions += SWAY * np.sin(2 * np.pi * turns) + rng.normal(0.0, noise, positions.shape)
    return Session(name, skeleton, positions.astype(np.float32), true)


def _rest(one: Floats, other: Floats, seconds: float) -> Floats:
    away = (np.arange(round(seconds * FPS)) / FPS - (seconds - CHANGE) / 2) / CHANGE
    share = np.clip(away, 0.0, 1.0)
    share = share * share * (3 - 2 * share)
    return one + share[:, None, None] * (other - one)


def _moving(shown: Floats) -> tuple[int, int]:
    """Return the frames where a performance leaves its first pose, and reaches its last one."""
    left, missing = (np.linalg.norm(shown - shown[k], axis=2).mean(axis=1) for k in (0, -1))
    begin = int(np.argmax(left > FAR * left.max()))
    return begin, len(shown) - 1 - int(np.argmax((missing > FAR * missing.max())[::-1]))


def made_sessions() -> Iterator[Session]:
    """Yield the sessions of the built-in performer."""
    for name, move in MOVES.items():
        for noise in NOISES:
            for seed in range(SEEDS):
                rng = np.random.default_rng([seed, len(name)])
                yield session(name, SKELETON, [performed(move)] * EACH, noise, rng)


def sessions_of(folder: Path) -> Iterator[Session]:
    """Yield the sessions of people's clips."""
    for path in sample_files(folder):
        examples = load_examples(path)
        for name, clips in examples.shown.items():
            rng = np.random.default_rng([len(name), len(clips[0])])
            shown = [clip.astype(np.float64) for clip in clips[:EACH]]
            yield session(name, examples.skeleton, shown, NOISE_OF_CLIPS, rng)


def play(one: Session) -> Outcome:
    """Return the examples that live teaching takes in a session."""
    taken: list[Movement] = []
    taker = MovementTaker(taken.append, lambda _: None)
    taker.announce(Meta("p1", one.skeleton))
    times = np.arange(len(one.positions)) / FPS
    for at in range(0, len(times), 3):
        part = slice(at, at + 3)
        taker.send_frames(Frames(one.positions[part], times[part], None, "p1"))
    return Outcome(one, [(movement.begin, movement.end) for movement in taken])


def report(title: str, outcomes: Sequence[Outcome], console: Console) -> float:
    """Print the right sessions, and return their share."""
    right = [one for one in outcomes if one.is_right]
    for name in dict.fromkeys(one.session.name for one in outcomes if not one.is_right):
        wrong = [len(one.taken) for one in outcomes if one.session.name == name and not one.is_right]
        console.line(f"  {name}: {', '.join(map(str, wrong))} taken of {EACH}")
    begins, ends = ([error for one in right for error in one.errors(k)] for k in (0, 1))
    console.line(
        f"{title}: {len(right)} of {len(outcomes)} sessions right; begin within {np.quantile(begins, 0.9):.2f} s, "
        f"end within {np.quantile(ends, 0.9):.2f} s (90 %)"
    )
    return len(right) / len(outcomes)


def main() -> int:
    """Play all sessions; return 1 if too many are wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("examples", metavar="EXAMPLES", type=Path, nargs="?")
    options = parser.parse_args()
    console = Console(sys.stdout, sys.stderr)
    shares = [report("made", [play(one) for one in made_sessions()], console)]
    if options.examples is not None:
        shares.append(report("people", [play(one) for one in sessions_of(options.examples)], console))
    return 0 if min(shares) >= LEAST else 1


if __name__ == "__main__":
    sys.exit(main())
