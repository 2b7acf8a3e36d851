"""The one loop, for body and limbs: room for a limb with more joints than its body, and one thread at a time."""

import msgspec
import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_stream import KeyFrameEvent, Segmenter, Settings, Skeleton
from mossar_stream.core import engine
from mossar_stream.core.kernels import run, run_one
from mossar_stream.moves.groups import groups_of

MARKERS = Skeleton(tuple(f"m{j}" for j in range(8)), (), -1)
ALL = "all=" + ",".join(MARKERS.names)  # a limb of all joints has their mean, too


def swinging(count=240):
    rng = np.random.default_rng(3)
    frames = rng.normal(0, 0.3, (1, 8, 3)) + rng.normal(0, 1e-5, (count, 8, 3))
    swing = 0.4 * np.sin(np.linspace(0, 6 * np.pi, 120)) * np.sin(np.linspace(0, np.pi, 120))
    frames[60:180, 1:4, 0] += swing[:, None]
    return frames.astype(np.float32), np.arange(count) / 30.0


def events_of(limbs, size):
    frames, times = swinging()
    segmenter = Segmenter(MARKERS, Settings(limbs=limbs))
    found = []
    for at in range(0, len(times), size):
        found += segmenter.push(frames[at : at + size], times[at : at + size])
    return found + segmenter.end_take()


def test_a_limb_may_need_more_room_than_its_body():
    assert len(groups_of(MARKERS, ALL)[0].joints) == 9
    found = events_of(ALL, 1)
    assert found == events_of(ALL, 64)
    body = [msgspec.structs.replace(e, limb=None) if hasattr(e, "limb") else e for e in found]
    assert [e for e in body if getattr(e, "channel", "body") == "body"] == events_of(False, 1)
    assert {e.channel for e in found if isinstance(e, KeyFrameEvent)} == {"body", "all"}


@pytest.mark.parametrize("limbs", [True, ALL])
def test_another_thread_gets_an_error(limbs):
    frames, times = swinging()
    segmenter = Segmenter(MARKERS, Settings(limbs=limbs))
    for k in range(10):
        segmenter.push(frames[k], float(times[k]))
    segmenter.row.buffers.is_busy = True
    with pytest.raises(RuntimeError, match="two threads"):
        segmenter.push(frames[10], float(times[10]))
    segmenter.row.buffers.is_busy = False
    segmenter.push(frames[10], float(times[10]))


def test_ctrl_c_right_after_the_compiled_call_loses_no_event(monkeypatch):
    take = performance(fps=30.0, seconds=12.0)
    settings = Settings(limbs=True, level=0.0)
    is_armed = False

    def interrupted(call):
        def called(*given):
            done = call(*given)
            if is_armed and buffers.events[:8].view(np.int64)[0] > 0:  # there are events
                raise KeyboardInterrupt
            return done

        return called

    monkeypatch.setattr(engine, "run", interrupted(run))
    monkeypatch.setattr(engine, "run_one", interrupted(run_one))
    whole, cut = Segmenter(take.skeleton, settings), Segmenter(take.skeleton, settings)
    buffers = cut.row.buffers
    expected, found, interrupted = [], [], 0
    for k, frame in enumerate(take.frames.positions):
        is_armed = False
        expected += whole.push(frame, k / 30)
        is_armed = True
        try:
            found += cut.push(frame, k / 30)
        except KeyboardInterrupt:
            interrupted += 1
    found += cut.end_take()
    assert interrupted > 10
    assert sorted(map(repr, found)) == sorted(map(repr, expected + whole.end_take()))
