"""What streams decide by evidence, compared with the same rule in plain Python."""

import json
from pathlib import Path

import numpy as np
import pytest

from checks.reference.algorithms import generate_key_frames
from checks.reference.counted import counted_by
from checks.reference.motion import Motion, algorithm_2
from mossar_stream import Segmenter, Skeleton
from mossar_stream.similarity.evidence import WEIGHTS

LABELLED = Path(__file__).parents[4] / "shared" / "data" / "labelled"
SAME = 0.1  # s


def compare(core, positions, fps, skeleton, status="final"):
    """Return how many key frames, of both, lie beside one of the other, and how many there are."""
    positions = np.ascontiguousarray(positions, np.float32)
    segmenter = Segmenter(skeleton, fps=fps)
    events = segmenter.push(positions) + segmenter.end_take()
    streamed = np.array(sorted({event.time for event in core.key_frames(events, status)}))
    motion = Motion(positions, fps, skeleton, counted_by(positions, fps, skeleton))
    # What is final without having been told of before is confirmed then.
    frames = {*motion.final(), *(motion.reported() if status == "confirmed" else ())}
    plain = np.array(sorted(frames)) / fps
    near = [
        sum(np.abs(two - time).min() <= SAME for time in one) if len(two) else 0
        for one, two in ((streamed, plain), (plain, streamed))
    ]
    return sum(near), len(streamed) + len(plain)


@pytest.mark.parametrize(
    ("pattern", "least"),
    # Streams keep poses in 1/8 mm, which decides where two candidates are as good: often, in punches of a few frames.
    [("precog/Seq*_1", 0.95), ("gesture_phase/*", 0.95), ("ui_prmd/m0*_s01", 0.95)],
)
@pytest.mark.parametrize("status", ["final", "confirmed"])
def test_streams_decide_as_the_plain_rule_does(core, pattern, least, status):
    paths = sorted(LABELLED.glob(f"{pattern}.json"))
    if not paths:
        pytest.skip("no labelled recordings in ../shared/data/labelled")
    same = total = 0
    for path in paths:
        archive = np.load(path.parent / json.loads(path.read_text())["recording"])
        skeleton = Skeleton(tuple(map(str, archive["joint_names"])), tuple(map(int, archive["parents"])))
        near, both = compare(core, archive["positions"], float(archive["fps"]), skeleton, status)
        same, total = same + near, total + both
    assert total > 40
    assert same >= least * total


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("fps", [30.0, 60.0, 100.0])
def test_so_they_do_for_the_built_in_performer(core, fps, noise):
    demo = pytest.importorskip("mossar_adapters.demo")
    same = total = 0
    for seed in range(4):
        shown = demo.performance(seed, fps=fps, noise=noise, seconds=20)
        near, both = compare(core, shown.frames.positions, fps, shown.skeleton)
        same, total = same + near, total + both
    assert total > 40
    assert same >= 0.95 * total


def test_more_must_be_outweighed_for_fewer_key_frames():
    demo = pytest.importorskip("mossar_adapters.demo")
    shown = demo.performance(2, fps=30.0, seconds=15)
    counted = counted_by(shown.frames.positions, 30.0, shown.skeleton)
    motion = Motion(shown.frames.positions, 30.0, shown.skeleton, counted)
    many, usual, none = (len(motion.final(WEIGHTS._replace(bias=bias))) for bias in (-20.0, 3.0, 500.0))
    assert many > usual > none


def test_the_moving_line_is_algorithm_2_where_it_stands_still():
    rng = np.random.default_rng(5)
    for _ in range(50):
        curve = np.abs(np.cumsum(rng.normal(0.0, 0.1, 80)))
        times = np.arange(80) / 30.0
        found = sorted(key[0] for key in algorithm_2(curve, np.full(80, 0.1), times))
        assert found == generate_key_frames(curve, 0.1).key_frames
