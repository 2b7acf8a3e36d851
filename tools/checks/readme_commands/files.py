"""Files that the commands of the documentation name, in a folder of its own for each command."""

import math
from pathlib import Path

import numpy as np
from pympi import Eaf

from checks.fuzz import recordings
from checks.gaits import GAITS, performed
from mossar_adapters.demo import performance
from mossar_adapters.files import read
from mossar_stream import Moves

TURNS = " Zrotation Xrotation Yrotation\n"
BONES = {
    "Spine": 12,
    "Chest": 12,
    "Neck": 15,
    "Head": 9,
    "LeftUpperArm": 12,
    "LeftLowerArm": 27,
    "LeftHand": 25,
}
STAGE = """
sources = ["osc://127.0.0.1:39539"]
stats = 5
"""
POSES = """
import json
print(json.dumps({"type": "meta", "names": ["hip", "hand"], "parents": [-1, 0]}))
for i in range(600):
    x = 0.3 * (1 - abs(i % 60 - 30) / 30) if i % 120 < 60 else 0
    print(json.dumps({"type": "frame", "t": i / 60, "xyz": [[0, 1, 0], [x, 1, 0.3]]}))
"""
FRAMES = "".join(
    [
        '{"type": "meta", "performer": "p1", "names": ["hip", "hand"], "parents": [-1, 0]}\n',
        *(
            f'{{"type": "frame", "performer": "p1", "t": {i / 30}, "xyz": [[0, 1, 0], [{i % 30 / 100}, 1, 0.3]]}}\n'
            for i in range(300)
        ),
    ]
)
LABELS = '{"recording": "%s", "fps": 30, "unit": "m", "cuts": [100, 200]}'


def furnish(folder: Path) -> None:
    """Put all files that the documentation names into a folder."""
    labelled = [folder / name for name in ("DIR", "FOLDER", "DIR1", "DIR2", "DIR3")]
    for place in (folder, *labelled):
        place.mkdir(parents=True)
    short = humanoid(300)
    contents = {
        "take.bvh": short,
        "walk.bvh": short,
        "squats.bvh": short,
        "ann_1_walk.bvh": short,
        "bo_1_walk.bvh": short,
        "long.bvh": humanoid(700, rate=1.0),
        "86_01.amc": recordings.amc(300),
        "86.asf": recordings.ASF,
        "take.c3d": recordings.c3d(),
        "walk.c3d": walking(),
        "take.msk": recordings.msk(300),
        "poses.py": POSES.encode(),
        "take.jsonl": FRAMES.encode(),
        "stage.toml": STAGE.encode(),
        "settings.toml": b"[settings]\nsig_threshold = 0.04\n",
        "walk.json": (LABELS % "walk.bvh").encode(),
        "labels.csv": b"start,end,name\n1.4,3.1,punch\n",
    }
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    for place in labelled:
        (place / "walk.npz").write_bytes(recordings.npz(300))
        (place / "walk.json").write_text(LABELS % "walk.npz")
    _annotate(folder / "take.eaf", 1400)
    _annotate(folder / "corrected.eaf", 1450)
    for labeller, start in (("ann", 1400), ("bo", 1520)):
        _annotate(folder / f"{labeller}.eaf", start)
        (folder / labeller.upper()).mkdir()
        _annotate(folder / labeller.upper() / "take.eaf", start)
    (folder / "found.csv").write_text("start,end,name\n1.45,3.0,punch\n")
    take = read(folder / "take.bvh", unit="cm")
    moves = Moves(take.skeleton)
    moves.add("punch", take.positions[40:95], 30.0)
    moves.add("squat", take.positions[130:190], 30.0)
    moves.save(folder / "moves.json")
    poses = Moves(take.skeleton)
    poses.add_pose("plank", take.positions[0])
    poses.save(folder / "poses.json")
    played = performance(1)
    shown = Moves(played.skeleton)
    shown.add("move", played.frames.positions[:240], played.fps)
    shown.save(folder / "shown.json")


def walking() -> bytes:
    """Return a C3D recording of a walk, with the markers of Plug-in Gait."""
    positions, _, _ = performed(GAITS["walking"], 12.0, 60.0, 0.001)
    labels = ("LFHD", "SACR", "LANK", "LHEE", "LTOE", "RANK", "RHEE", "RTOE")
    return recordings.c3d(labels=labels, positions=positions.astype(np.float64))


def _annotate(path: Path, start: int) -> None:
    """Write a tier with one move that starts after so many ms."""
    annotations = Eaf()
    annotations.remove_tier("default")
    annotations.add_tier("moves")
    annotations.add_annotation("moves", start, 3100, "punch")
    annotations.to_file(str(path))


def humanoid(frames: int, rate: float = 30.0) -> bytes:
    """Return a BVH recording of a chain of bones that have names of a humanoid; it swings for half of the time."""
    text = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition" + TURNS
    for name, length in BONES.items():
        text += f"JOINT {name}\n{{\nOFFSET 0 {length} 0\nCHANNELS 3{TURNS}"
    text += "End Site\n{\nOFFSET 0 10 0\n}\n" + "}\n" * (len(BONES) + 1)
    text += f"MOTION\nFrames: {frames}\nFrame Time: {1 / rate:.7f}\n"
    for i in range(frames):
        angle = 40.0 * math.sin(i / 10) if i % 90 > 45 else 0.0
        text += f"0 90 0 0 0 0{f' 0 {angle:.3f} 0' * len(BONES)}\n"
    return text.encode()
