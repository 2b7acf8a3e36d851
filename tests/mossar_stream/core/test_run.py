"""The one loop, for body and limbs: room for a limb with more joints than its body, and one thread at a time."""

import msgspec
import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_stream import KeyFrameEvent, Segmenter, Settings, Skeleton
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
    segmenter.core.workspace.is_busy = True
    with pytest.raises(RuntimeError, match="two threads"):
        segmenter.push(frames[10], float(times[10]))
    segmenter.core.workspace.is_busy = False
    segmenter.push(frames[10], float(times[10]))


def test_memory_is_not_given_back_while_another_thread_works_on_it():
    frames, times = swinging()
    segmenter = Segmenter(MARKERS, Settings(limbs=ALL))
    segmenter.push(frames, times)
    segmenter.core.workspace.is_busy = True
    with pytest.raises(RuntimeError, match="two threads"):
        segmenter.release()
    segmenter.core.workspace.is_busy = False
    assert segmenter.end_take()[-1].event == "ended"


def test_what_was_released_says_so():
    frames, times = swinging()
    segmenter = Segmenter(MARKERS, Settings(limbs=ALL))
    segmenter.push(frames, times)
    segmenter.release()
    segmenter.release()
    for request in (
        lambda: segmenter.push(frames, times),
        lambda: segmenter.push(frames[0], float(times[0])),
        segmenter.end_take,
        segmenter.snapshot,
        lambda: segmenter.stats,
        lambda: segmenter.change(window=0.1),
        lambda: segmenter.state,
    ):
        with pytest.raises(RuntimeError, match="was released"):
            request()


class Interrupted:
    """A performer whose calls are cut short as soon as they have caused events, as Ctrl-C does it."""

    def __init__(self, core):
        self._core, self.is_armed = core, False

    def __getattr__(self, name):
        found = getattr(self._core, name)
        return self._interrupted(found) if name in ("process", "process_one") else found

    def _interrupted(self, call):
        def called(*given):
            done = call(*given)
            if self.is_armed and self._core.pending:
                raise KeyboardInterrupt
            return done

        return called


@pytest.mark.parametrize("chunk", [1, 4])
def test_ctrl_c_right_after_the_compiled_call_loses_no_event(chunk):
    take = performance(fps=30.0, seconds=12.0)
    settings = Settings(limbs=True, level=0.0)
    whole, cut = Segmenter(take.skeleton, settings), Segmenter(take.skeleton, settings)
    cut.core = Interrupted(cut.core)
    expected, found, interrupted = [], [], 0
    for k in range(0, len(take.frames.positions), chunk):
        frames, times = take.frames.positions[k : k + chunk], np.arange(k, k + chunk) / 30
        expected += whole.push(frames, times[: len(frames)])
        cut.core.is_armed = True
        try:
            found += cut.push(frames, times[: len(frames)])
        except KeyboardInterrupt:
            interrupted += 1
            cut.core.is_armed = False
            found += cut.push(frames[:0], times[:0])  # what waits comes with the next call
    assert interrupted > 10
    cut.core = cut.core._core
    assert list(map(repr, found + cut.end_take())) == list(map(repr, expected + whole.end_take()))
