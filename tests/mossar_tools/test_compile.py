"""`mossar compile` compiles all that other commands need, so that none of them waits later."""

import subprocess
import sys

EVERYTHING = """
import importlib, pkgutil
import mossar_stream
from mossar_stream.jit import cache
from numba.core.dispatcher import Dispatcher
from mossar_adapters.demo import performance
from mossar_tools.commands import compile
from mossar_tools.console import console
from mossar_tools.options import Options

BASELINE = {"mossar_stream.similarity.comparison"}  # of a check only; no command uses it
compile.run(Options(), console())
entries = {}
for module in pkgutil.walk_packages(mossar_stream.__path__, "mossar_stream."):
    if module.name not in BASELINE:
        for name, value in vars(importlib.import_module(module.name)).items():
            if isinstance(value, Dispatcher) and isinstance(value._cache, cache.SturdyCache):
                entries[f"{value.py_func.__module__}.{value.py_func.__name__}"] = value
kept = {name: list(value.signatures) for name, value in entries.items()}
LATER
print(len(entries))
for name, value in entries.items():
    if not kept[name] or list(value.signatures) != kept[name]:
        print(name, *value.signatures, sep="; ")
"""
LATER = """
from mossar_stream import Moves, Performers, Segmenter, Settings, Skeleton, segment_recording
take = performance(7, fps=30.0, seconds=8.0, moves=["rest:1", "punch_left", "rest:1", "squat", "rest:1"])
frames = take.frames
moves = Moves(take.skeleton)
moves.add("punch", frames.positions[:90], fps=30)
moves.add_pose("stand", frames.positions[0])
moves.set_rule("stand", mirrored=True)
for similarity in ("evidence", "likelihood", "path_kernel"):
    settings = Settings(similarity=similarity, limbs=True, steps=True, repetitions=True, phase=True)
    Segmenter(take.skeleton, settings, moves=moves, follow=True, fps=30).push(frames)
    segment_recording(frames.positions, 30, take.skeleton, settings=settings, moves=moves, follow=True)
"""


def test_no_option_compiles_anything_later():
    done = subprocess.run(
        [sys.executable, "-c", EVERYTHING.replace("LATER", LATER)],
        check=False,
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, done.stderr
    count, *missing = done.stdout.splitlines()
    assert int(count) > 10
    assert missing == []
