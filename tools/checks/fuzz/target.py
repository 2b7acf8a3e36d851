"""Target: a reader of foreign data, and its record with damaged input."""

import random
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager

import msgspec

from checks.fuzz.guard import Hang, time_limit
from checks.fuzz.mutation import Mutator
from mossar_stream import MossarError

ROUND = 500  # inputs that share a state, where each takes little time
KEPT = 5  # crashes of one kind that are kept

Feed = Callable[[bytes], object]
Draw = Callable[[random.Random], Callable[[], bytes]]


class Target(msgspec.Struct, frozen=True):
    """A reader that is fed.

    Args:
        name: For the user.
        share: Its part of all inputs, relative to the other targets.
        open: Returns a function of one input, for a round.
        samples: Real input to be damaged.
        words: Words to insert.
        draw: Makes inputs in another way, given chance; None for damaged samples.
        round: How many inputs share a state.
    """

    name: str
    share: float
    open: Callable[[], AbstractContextManager[Feed]]
    samples: Sequence[bytes] = ()
    words: Sequence[bytes] = ()
    draw: Draw | None = None
    round: int = ROUND


class Crash(msgspec.Struct, frozen=True):
    """An input that something failed on.

    Args:
        kind: Where and how it failed; crashes of one kind have one cause.
        round: Round in which it came.
        data: The input.
        trace: The traceback.
    """

    kind: str
    round: int
    data: bytes
    trace: str


class Tally(msgspec.Struct):
    """Record of a target.

    Args:
        inputs: How many it was given.
        refused: How many of them it refused, as it should.
        seconds: Time that took.
        slowest: Longest time of the processor that one input took, s.
        crashes: Those kept.
        failed: All inputs that it failed on.
    """

    inputs: int = 0
    refused: int = 0
    seconds: float = 0.0
    slowest: float = 0.0
    crashes: list[Crash] = msgspec.field(default_factory=list)
    failed: int = 0


def run_round(target: Target, seed: int, number: int, count: int, tally: Tally) -> None:
    """Feed a target for a round; the same seed and number make the same inputs.

    Args:
        target: The target.
        seed: Of the whole run.
        number: Of the round.
        count: Inputs.
        tally: Takes the result in.
    """
    rng = random.Random(f"{seed} {target.name} {number}")  # noqa: S311 - not for secrets
    draw = target.draw(rng) if target.draw else Mutator(rng, target.samples, target.words).next
    began = time.perf_counter()
    with target.open() as feed:
        for _ in range(count):
            data = draw()
            started = time.process_time()
            try:
                with time_limit:
                    feed(data)
            except MossarError as error:
                tally.refused += 1
                if not str(error).isprintable():
                    _keep(tally, error, number, data)
            except (Exception, Hang) as error:  # noqa: BLE001 - finding these is the point
                _keep(tally, error, number, data)
            tally.slowest = max(tally.slowest, time.process_time() - started)
    tally.inputs += count
    tally.seconds += time.perf_counter() - began


def _keep(tally: Tally, error: BaseException, number: int, data: bytes) -> None:
    tally.failed += 1
    frames = traceback.extract_tb(error.__traceback__)
    place = f"{frames[-1].filename.rpartition('/')[2]}:{frames[-1].lineno}" if frames else "?"
    kind = f"{type(error).__name__} at {place}"
    if sum(crash.kind == kind for crash in tally.crashes) < KEPT:
        trace = "".join(traceback.format_exception(error))
        tally.crashes.append(Crash(kind, number, data, trace))
