"""Comparison of the events of another version, byte for byte, and of the times of both, in turns.

    git worktree add ../before COMMIT
    python -m checks.same_events ../before take.bvh other.amc --set preset=paper

Both versions get the same frames, in single pushes and in chunks of 64, each in processes of its own; the time is
processor time of the single pushes, the least of several turns. Features that are off by default, such as limbs, moves
and repetitions, must change nothing. The exit status is 1 if events differ, or if this version takes more than `MORE` longer.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mossar_adapters.files import read

ROOT = Path(__file__).parents[2]
MORE = 0.03  # of the time before
TURNS = 5
FRAMES = 20_000  # that are timed, of recordings gone through again and again
PROGRAM = """
import hashlib, json, sys, time
import numpy as np
from mossar_stream import Segmenter, Settings, Skeleton
given = json.loads(sys.argv[1])
settings = dict(given["settings"])
settings = Settings.build(settings.pop("preset", "default"), settings)
found, frames = [], []
for path in given["paths"]:
    take = np.load(path)
    skeleton = Skeleton(tuple(map(str, take["names"])), tuple(map(int, take["parents"])), int(take["root"]))
    positions, times, fps = take["positions"], take["times"], float(take["fps"]) or None
    from mossar_stream.events import to_json
    for size in (1, 64):
        segmenter, digest = Segmenter(skeleton, settings, fps=fps), hashlib.sha256()
        events = 0
        for at in range(0, len(times), size):
            for event in segmenter.push(positions[at : at + size], times[at : at + size]):
                digest.update(to_json(event)); events += 1
        for event in segmenter.end_take():
            digest.update(to_json(event)); events += 1
        found.append([digest.hexdigest(), events])
    segmenter, period = Segmenter(skeleton, settings, fps=fps), float(times[-1]) + 0.01
    turns = -(-given["frames"] // len(times))
    singles = [(p, t + k * period) for k in range(turns) for p, t in zip(positions, times.tolist())]
    begin = time.process_time()
    for position, moment in singles:
        segmenter.push(position, moment)
    frames.append((time.process_time() - begin) / len(singles))
print(json.dumps([found, sum(frames) / len(frames)]))
"""


def told(tree: Path, paths: Sequence[Path], settings: dict[str, Any], frames: int) -> tuple[list[Any], float]:
    """Return the events of the version in a folder, as digests, and its time for a frame, s."""
    given = json.dumps({"paths": [str(path) for path in paths], "settings": settings, "frames": frames})
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    done = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", PROGRAM, given],
        cwd=tree,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    found, seconds = json.loads(done.stdout)
    return found, float(seconds)


def written(folder: Path, recordings: Sequence[str]) -> list[Path]:
    """Write recordings in a form that every version reads: arrays, as the reader of this version has them."""
    paths = []
    for k, name in enumerate(recordings):
        take = read(name)
        skeleton = take.skeleton
        paths.append(folder / f"{k}.npz")
        np.savez(
            paths[-1],
            positions=np.ascontiguousarray(take.positions, np.float32),
            times=take.times,
            names=skeleton.names,
            parents=skeleton.parents or [-1] * len(skeleton),
            root=skeleton.root,
            fps=take.fps or 0.0,
        )
    return paths


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("before", type=Path, help="folder of the other version")
    parser.add_argument("recordings", nargs="+")
    parser.add_argument("--set", metavar="NAME=VALUE", action="append", default=[], dest="settings")
    parser.add_argument("--turns", type=int, default=TURNS)
    given = parser.parse_args()
    settings = dict(text.split("=", 1) for text in given.settings)
    with tempfile.TemporaryDirectory() as name:
        paths = written(Path(name), given.recordings)
        runs = [
            [told(tree.absolute(), paths, settings, FRAMES) for tree in (given.before, ROOT)]
            for _ in range(given.turns)
        ]
    same = runs[0][0][0] == runs[0][1][0]
    before, now = (min(turn[which][1] for turn in runs) for which in (0, 1))
    events = sum(count for _, count in runs[0][1][0])
    print(f"events: {events}, {'the same' if same else 'OTHERS'}")
    print(f"a frame: {before * 1e6:.2f} us before, {now * 1e6:.2f} us now, {now / before - 1:+.1%}")
    sys.exit(0 if same and now <= (1 + MORE) * before else 1)


if __name__ == "__main__":
    main()
