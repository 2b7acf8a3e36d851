"""How often a move is said that nobody made, with the examples of one player at a time, in recordings of other people.

    python -m checks.false_moves EXAMPLES LABELLED [--each] [--list]

EXAMPLES is a folder as for `mossar evaluate` with an archive of segmented examples for each player; LABELLED holds
labelled recordings of other things. Recordings that lack joints which the examples need are refused, and left out.

Most of what is said in a recording of punches and kicks is right, though nobody asked for it. So what is said is told
apart by what the body does in its time, measured without the recogniser:

- kicks: a move called `kick` while that foot is raised by at least `RAISED` of the body's height above its lowest place
- punches: a move called `jab`, `hook`, `uppercut` or `push` while that hand gets at least `REACHED` of the arm's length
  nearer to its stretch or farther from it, and passes `FAST`

where the recording's label says that it holds such moves (`KICKS_AND_PUNCHES`). Everything else is false.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import FrameError, MoveEvent, Moves, Segmenter, Settings
from mossar_tools.console import Console
from mossar_tools.evaluation.sessions import load_examples, load_sessions, sample_files
from mossar_tools.evaluation.takes import Take, load_folder

KICKS_AND_PUNCHES = ("precog/", "86_01")
RAISED, REACHED = 0.12, 0.3
FAST = 1.5  # m/s


class Said(msgspec.Struct, frozen=True):
    """A move that was confirmed in a recording."""

    take: str
    move: str
    start: float  # s
    end: float  # s
    is_right: bool


def said_in(take: Take, moves: Moves) -> list[Said]:
    """Return what is confirmed in a recording.

    Raises:
        FrameError: If it lacks joints that the examples need.
    """
    segmenter = Segmenter(take.skeleton, Settings(), fps=take.fps, moves=moves)
    events = [*segmenter.push(take.positions, take.times), *segmenter.end_take()]
    return [
        Said(take.name, event.name, event.start, event.end, False)
        for event in events
        if isinstance(event, MoveEvent) and event.status == "confirmed"
    ]


