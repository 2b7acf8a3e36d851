r"""Scores of level `motion` on data that its weights never saw.

    python -m checks.leave_out SET1 SET2 SET3 ...
    python -m checks.leave_out SET --people 's\d+'

Each SET is a labelled folder as for `mossar evaluate`. The numbers of `similarity/evidence.pxi` (`WEIGHTS_…`) are chosen anew on all sets but
one, and that one is scored, for each set in turn. The last row has the scores of all sets with numbers chosen on all of them.
With --people each set is divided by performer, the first match of the pattern in a take's name. The search does not start
from the numbers in force: it draws weights from wide ranges (`LARGEST`), and goes on around the best ones. The rest of the
rule stays the same. The rule is the plain one of `reference/motion.py`, which gives nearly the key frames of a stream; it
takes a quarter of an hour for 180 recordings.
"""

import argparse
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
import numpy as np

from checks.reference.counted import counted_by
from checks.reference.motion import Motion, without_gaps
from mossar_stream.similarity.evidence import LARGEST, WEIGHTS, Weights
from mossar_tools.console import Console
from mossar_tools.evaluation.matching import Cut, match
from mossar_tools.evaluation.takes import Take, load_folder

DRAWN, REFINED = 100, 30  # vectors of weights that are tried on all sets, and on all but one
STEP = 0.15  # standard deviation of a refinement, as a share of the weight
ALL = "none"  # name of the run that leaves no set out
AVERAGED = 5  # best vectors whose mean is taken


class Set(msgspec.Struct, frozen=True):
    """A labelled set, ready to be scored.

    Args:
        motions: Input of the rule for each recording.
        takes: The recordings, with their cuts.
    """

    motions: list[Motion]
    takes: list[Take]

    def f1(self, weights: Weights) -> float:
        """Return the mean F1 of the final key frames."""
        return float(np.mean([_f1(*pair, weights) for pair in zip(self.motions, self.takes, strict=True)]))


class LeftOut(msgspec.Struct, frozen=True):
    """Score on a set that was left out.

    Args:
        in_force: F1 with the weights in force, which every set had a part in.
        left_out: F1 with those chosen on the others.
        weights: The latter.
    """

    in_force: float
    left_out: float
    weights: Weights


def _f1(motion: Motion, take: Take, weights: Weights) -> float:
    times = [frame / take.fps for frame in motion.final(weights)]
    cuts: Sequence[Cut] = take.cuts
    return 2 * len(match(times, cuts, take.tolerance)) / max(1, len(times) + len(cuts))


def prepare(takes: Sequence[Take]) -> Set:
    """Return a set whose evidence is computed, which does not depend on weights."""
    motions = []
    for take in takes:
        positions = without_gaps(take.positions)  # type: ignore[arg-type]
        counted = counted_by(positions, take.fps, take.skeleton)
        motions.append(Motion(positions, take.fps, take.skeleton, counted))
    return Set(motions, list(takes))


def divided(name: str, takes: Sequence[Take], people: re.Pattern[str] | None) -> dict[str, list[Take]]:
    """Return the takes of a set under its name, or those of each performer if there is a pattern."""
    parts: dict[str, list[Take]] = {}
    for take in takes:
        performer = people.search(take.name) if people else None
        parts.setdefault(f"{name} {performer.group()}" if performer else name, []).append(take)
    return parts


def draw(rng: np.random.Generator) -> Weights:
    """Return weights from the whole of their ranges."""
    return Weights(*(rng.random(len(LARGEST)) * LARGEST).tolist())


def around(weights: Weights, rng: np.random.Generator) -> Weights:
    """Return weights near to others."""
    steps = rng.normal(0.0, STEP, len(LARGEST)) * (rng.random(len(LARGEST)) < 0.5)
    return Weights(*np.clip(np.array(weights) + steps * LARGEST, 0.0, None).tolist())


def leave_out(sets: Mapping[str, Set], drawn: int, refined: int, seed: int = 0) -> dict[str, LeftOut]:
    """Return the scores of each set with weights chosen on the others, and as `ALL` those of all with weights chosen on all.

    Args:
        sets: At least two.
        drawn: Vectors that are tried at first, the same for all.
        refined: Vectors that are tried near to the best, for each set that is left out.
        seed: Of the draws.
    """
    rng = np.random.default_rng(seed)
    first = [draw(rng) for _ in range(drawn)]
    scores = [{name: one.f1(weights) for name, one in sets.items()} for weights in first]
    found = {}
    for name in (*sets, ALL):
        others = [one for other, one in sets.items() if other != name]
        tried = [
            (float(np.mean([score[other] for other in sets if other != name])), weights)
            for score, weights in zip(scores, first, strict=True)
        ]
        for _ in range(refined):
            near = around(max(tried)[1], rng)
            tried.append((float(np.mean([one.f1(near) for one in others])), near))
        best = sorted(tried, reverse=True)[:AVERAGED]
        chosen = Weights(*np.mean([weights for _, weights in best], axis=0).tolist())
        scored = list(sets.values()) if name == ALL else [sets[name]]
        before, after = (float(np.mean([one.f1(by) for one in scored])) for by in (WEIGHTS, chosen))
        found[name] = LeftOut(before, after, chosen)
    return found


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", metavar="SET", nargs="+", type=Path)
    parser.add_argument("--drawn", type=int, default=DRAWN)
    parser.add_argument("--refined", type=int, default=REFINED)
    parser.add_argument("--people", metavar="PATTERN", type=re.compile, help="a performer, in a take's name")
    given = parser.parse_args()
    console = Console(sys.stdout, sys.stderr)
    sets = {
        part: prepare(takes)
        for folder in given.folders
        for part, takes in divided(folder.name, load_folder(folder, console.status), given.people).items()
    }
    found = leave_out(sets, given.drawn, given.refined)
    for name, one in found.items():
        weights = " ".join(f"{weight:.1f}" for weight in one.weights)
        console.line(
            f"{name:<20} in force {one.in_force:.3f}   left out {one.left_out:.3f}   weights {weights}"
        )
    del found[ALL]
    means = [np.mean([getattr(one, what) for one in found.values()]) for what in ("in_force", "left_out")]
    console.line(f"{'mean':<20} in force {means[0]:.3f}   left out {means[1]:.3f}")


if __name__ == "__main__":
    main()
