import numpy as np
import pytest

from mossar_adapters.pipeline import Pipeline
from mossar_adapters.pipeline.odd_times import OddTimes
from mossar_stream import Frames


def frames(times):
    return Frames(np.zeros((len(times), 1, 3), np.float32), np.array(times, np.float64))


@pytest.mark.parametrize(
    ("factor", "unit"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")]
)
@pytest.mark.parametrize("size", [1, 2, 50])
def test_times_in_another_unit_are_noticed_once_after_the_third_take(factor, unit, size):
    odd = OddTimes()
    times = np.arange(50) * factor / 30
    found = [odd.finding(frames(times[i : i + size]), 1.0) for i in range(0, 50, size)]
    told = [(i, text) for i, text in enumerate(found) if text]
    assert len(told) == 1
    assert f"in {unit} that would be 30 frames a second" in told[0][1]
    assert told[0][0] * size <= 4


def test_seconds_and_pauses_are_not_odd():
    odd = OddTimes()
    times = np.concatenate([np.arange(10) / 30 + 60 * k for k in range(5)])
    assert not any(odd.finding(frames(times[i : i + 1]), 1.0) for i in range(50))
    assert odd.finding(frames(times), 1.0) is None
    assert "max_pause" in odd.finding(frames(np.arange(5) * 2.0), 1.0)


def test_a_run_logs_it(stage, caplog):
    wave = stage.wave(0, 20)
    wave.times[:] *= 1000
    Pipeline([stage.Script([stage.meta(), wave])], [stage.Collected()]).run()
    assert sum("milliseconds" in message for message in caplog.messages) == 1
