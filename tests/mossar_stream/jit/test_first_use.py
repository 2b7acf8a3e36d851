"""New processes: kernels that lie on disk are loaded whatever is used first, and none is compiled between frames."""

import subprocess
import sys

import pytest

BEGIN = """
import numpy as np
from numba.core import event
from mossar_stream import Comparison, Moves, Performers, Segmenter, Settings, Skeleton

class Heard(event.Listener):
    count = 0
    def on_start(self, _):
        Heard.count += 1
    def on_end(self, _):
        pass

times = np.arange(120) / 60
pair = Skeleton(("hip", "hand"), (-1, 0))
wave = np.zeros((120, 2, 3), np.float32)
wave[:, 1, 0] = np.sin(3 * times)
moves = Moves(pair)
moves.add("wave", wave, fps=60.0)
"""
# What runs kernels of its own before it makes a segmenter, or without one.
FIRST_USES = {
    "a segmenter with moves": "Segmenter(pair, moves=moves)",
    "a pool with moves": "pool = Performers(); pool.moves = moves; pool.announce('ann', pair)",
    "kinds": "moves.kinds(); moves.costs(wave, 60.0)",
    "a comparison": "Comparison(wave, times, Settings(), 0, 0.1, 5).between(0, 10, 10)",
}


@pytest.mark.parametrize("use", FIRST_USES)
def test_kernels_are_compiled_once_and_then_loaded(use):
    heard = "event.register('numba:compile', Heard())"
    program = [sys.executable, "-c", f"{BEGIN}\n{heard}\n{FIRST_USES[use]}\nprint(Heard.count)"]
    subprocess.run(program, capture_output=True, check=True)  # whoever comes first may compile
    told = subprocess.run(program, capture_output=True, check=True)
    assert told.stdout.split() == [b"0"]


FRAMES = """
segmenter = Segmenter(pair, Settings(repetitions=True, phase=True), moves=moves)
event.register("numba:compiler_lock", Heard())
segmenter.push(wave[:1], times[:1])
for frame, time in zip(wave[1:], times[1:].tolist()):
    segmenter.push(frame, time)
segmenter.end_take()
print(Heard.count)
"""


def test_nothing_is_compiled_while_frames_come_in():
    told = subprocess.run([sys.executable, "-c", BEGIN + FRAMES], capture_output=True, check=True)
    assert told.stdout.split() == [b"0"]
