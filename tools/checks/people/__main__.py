"""Shares of people who keep their slots, in seeded scenes made of recordings of single people.

    python -m checks.people [FOLDER ...] [--scenes 1000] [--seed 1] [--draw N DIR]

Each FOLDER holds recordings of several people, as NAME_PERSON.npz (or PERSON.npz), metres. Scenes put people of one
folder side by side, let them cross, hide them, and have a tracker cut, exchange and reuse their ids. Everything is played
through the source that `--people` makes. Rows:

- short: two to four people, hidden for at most 2 s, also when they cross.
- back: all people leave for 10 to 20 s, and come back in another order, elsewhere, under other ids.
- cost: microseconds for a frame of a person, the median of scenes, each the least of five turns.

The exit status is 1 if a figure misses its target.
"""

import argparse
import itertools
import statistics
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec

from checks.people.actors import Actor, read_casts
from checks.people.judge import Verdict, cost, judge
from checks.people.pictures import draw
from checks.people.scenes import Scene, long_scene, short_scene
from mossar_stream import MossarError
from mossar_tools.console import Console

FOLDERS = tuple(
    Path("../shared/data") / part for part in ("labelled/precog", "labelled/ui_prmd", "moves/kinect/sessions")
)
_COSTS = 15  # scenes that cost is measured on
_TURNS = 5  # of which the least counts: other programs only ever add to it


class Row(msgspec.Struct):
    """A figure, and its target."""

    name: str
    value: float
    wanted: float
    at_most: bool = False

    @property
    def holds(self) -> bool:
        """Whether it is good enough."""
        return self.value <= self.wanted if self.at_most else self.value >= self.wanted


def share_right(verdicts: list[Verdict]) -> float:
    """Return the share of the frames in the right slot."""
    return sum(v.right for v in verdicts) / max(sum(v.frames for v in verdicts), 1)


def share_back(verdicts: list[Verdict]) -> float:
    """Return the share of people who came back to their slot."""
    return sum(v.found for v in verdicts) / max(sum(v.returns for v in verdicts), 1)


def rows(casts: list[list[Actor]], scenes: int, seed: int, console: Console) -> Iterator[Row]:
    """Yield the figures."""
    everything: list[Verdict] = []

    def played(made: Iterator[Scene], count: int, what: str) -> list[Verdict]:
        found = []
        for number, scene in enumerate(itertools.islice(made, count), 1):
            found.append(judge(scene))
            console.status(f"{what}: {number} of {count} scenes")
        everything.extend(found)
        return found

    turns = list(itertools.islice(itertools.cycle(casts), scenes))
    short = [(cast, seed * 100_000 + i) for i, cast in enumerate(turns)]
    yield Row(
        "short: frames in the right slot",
        share_right(played((short_scene(*one) for one in short), scenes, "short")),
        0.99,
    )
    each = max(scenes // 10, 1)
    for people, wanted in ((2, 0.95), (6, 0.8)):
        for cast in casts:
            count = min(people, len(cast))
            made = (long_scene(cast, seed * 100_000 + i, count) for i in range(each))
            name = f"back: {count} people, {cast[0].name.split('/')[0]}"
            yield Row(name, share_back(played(made, each, name)), wanted)
    yield Row("two people in one slot", sum(v.doubles for v in everything), 0, at_most=True)
    yield Row("frames of another id, without a word", sum(v.silent for v in everything), 0, at_most=True)
    chosen = [short_scene(cast, seed) for cast, seed in short[:_COSTS]]
    for chunk, most in ((1, 10.0), (10, 2.0)):
        name = "cost, frame by frame, us" if chunk == 1 else f"cost, chunks of {chunk}, us"
        least = [min(cost(scene, chunk) for _ in range(_TURNS)) for scene in chosen]
        yield Row(name, statistics.median(least), most, at_most=True)


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", metavar="FOLDER", type=Path, nargs="*", default=FOLDERS)
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--draw", metavar=("N", "DIR"), nargs=2, help="draw the first N scenes into DIR instead"
    )
    given = parser.parse_args()
    console = Console(sys.stdout, sys.stderr)
    try:
        casts = read_casts(given.folders)
    except MossarError as error:
        parser.error(str(error))
    if given.draw:
        for i in range(int(given.draw[0])):
            scene = short_scene(casts[i % len(casts)], given.seed * 100_000 + i)
            draw(scene, judge(scene), Path(given.draw[1]) / f"scene_{i:03}.png")
        return
    holds = True
    for row in rows(casts, given.scenes, given.seed, console):
        console.clear()
        sign = "<=" if row.at_most else ">="
        console.line(
            f"{row.name:<42}{row.value:>9.4g}   {sign} {row.wanted:<6g}{'' if row.holds else 'MISSED'}"
        )
        holds &= row.holds
    sys.exit(0 if holds else 1)


if __name__ == "__main__":
    main()
