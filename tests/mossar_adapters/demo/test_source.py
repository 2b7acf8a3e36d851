"""The `demo:` source: chunks in order of time, equal to whole performances, paced, closed."""

import itertools
import threading

import numpy as np
import pytest

from mossar_adapters.demo import SKELETON, DemoSource, performance
from mossar_adapters.demo.source import KNOWN_CUTS
from mossar_adapters.source import Meta, Source
from mossar_stream import Frames, SettingsError


def gathered(source):
    """Return positions and times by performer, and check the numbering."""
    parts = {}
    for item in source.items():
        if isinstance(item, Frames):
            mine = parts.setdefault(item.performer, [])
            assert item.first_frame == sum(len(part) for part in mine)
            mine.append(item)
    return {
        name: (np.concatenate([p.positions for p in chunks]), np.concatenate([p.times for p in chunks]))
        for name, chunks in parts.items()
    }


def test_starts_with_a_meta_per_performer():
    url = "demo:?performers=3&fps=50"
    source: Source = DemoSource.from_url(url, speed="max")
    metas = list(itertools.islice(source.items(), 3))
    assert metas == [Meta(f"p{k}", SKELETON, 50.0, recording=url) for k in (1, 2, 3)]


def test_chunks_together_are_the_whole_performance():
    source = DemoSource.from_url("demo:?seed=3&seconds=20&noise=0.01", speed="max")
    ((name, (positions, times)),) = gathered(source).items()
    take = performance(3, seconds=20, noise=0.01)
    assert name == "p1"
    np.testing.assert_array_equal(positions, take.frames.positions)
    np.testing.assert_array_equal(times, take.frames.times)
    assert source.cuts == {"p1": take.cuts}


@pytest.mark.parametrize("extra", ["", "&drop=0.3&jitter=0.01&noise_kind=kinect&noise=0.01", "&fps=24"])
def test_performers_are_independent_of_their_interleaving(extra):
    together = DemoSource.from_url(f"demo:?seed=5&performers=3&seconds=8{extra}", speed="max")
    options = dict(option.split("=") for option in extra.split("&") if option)
    numbers = {name: text if name == "noise_kind" else float(text) for name, text in options.items()}
    seen = gathered(together)
    for k in range(3):
        positions, times = seen[f"p{k + 1}"]
        alone = performance(5 + k, seconds=8, performer=f"p{k + 1}", place=(2.0 * k, 0.0), **numbers)
        np.testing.assert_array_equal(positions, alone.frames.positions)
        np.testing.assert_array_equal(times, alone.frames.times)
        assert together.cuts[f"p{k + 1}"] == alone.cuts


def test_chunks_of_all_performers_come_in_order_of_time():
    source = DemoSource.from_url("demo:?performers=2&seconds=5", speed="max")
    chunks = [item for item in source.items() if isinstance(item, Frames)]
    starts = [chunk.times[0] for chunk in chunks]
    assert starts == sorted(starts)
    assert {chunk.performer for chunk in chunks[:2]} == {"p1", "p2"}
    assert max(len(chunk) for chunk in chunks) == 2


def test_goes_on_without_end_by_default():
    source = DemoSource(2, speed="max")
    frames = sum(len(item) for item in itertools.islice(source.items(), 3000) if isinstance(item, Frames))
    assert frames > 5900
    assert len(source.cuts["p1"]) > 30


def test_moves_bound_it_too():
    source = DemoSource.from_url("demo:?moves=rest:1,punch_left,stand:2", speed="max")
    (_, times) = gathered(source)["p1"]
    assert 5 < times[-1] < 7
    assert [cut.after for cut in source.cuts["p1"]] == ["punch_left", "stand"]


def test_cuts_become_known_with_the_frame_they_lie_on():
    source = DemoSource.from_url("demo:?seconds=20", speed="max")
    truth = performance(1, seconds=20).cuts
    for item in source.items():
        if isinstance(item, Frames):
            known = sum(cut.frame < item.first_frame + len(item) for cut in truth)
            assert source.cuts["p1"] == truth[:known]
    assert source.cuts["p1"] == truth


def test_only_the_latest_cuts_are_remembered():
    source = DemoSource.from_url("demo:?fps=1&tempo=5&seconds=1500", speed="max")
    for _ in source.items():
        pass
    assert len(source.cuts["p1"]) == KNOWN_CUTS


def test_a_single_performer_can_be_named():
    source = DemoSource.from_url("demo:?performer=anna%20b&seconds=1", speed="max")
    assert set(gathered(source)) == {"anna_b"}


def test_live_unless_it_runs_at_full_speed():
    assert DemoSource(speed=1.0).live
    assert not DemoSource(speed="max").live


def test_a_slow_or_paused_source_says_that_nothing_came():
    source = DemoSource(speed=1.0)
    items = source.items()
    assert isinstance(next(items), Meta)
    assert isinstance(next(items), Frames)
    source.pacer.pause()
    assert next(items) is None
    source.pacer.resume()
    assert any(isinstance(item, Frames) for item in itertools.islice(items, 5))


def test_close_from_another_thread_ends_a_source_that_waits():
    source = DemoSource.from_url("demo:?fps=1", speed=0.001)
    arrived = []
    reader = threading.Thread(target=lambda: arrived.extend(source.items()))
    reader.start()
    source.close()
    source.close()
    reader.join(timeout=10)
    assert not reader.is_alive()


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("demo:?sed=3", "has no option 'sed'; there are seed, performers, .*noise"),
        ("demo:?seed=x", "option seed must be a whole number from 0, not 'x'"),
        ("demo:?seed=", "option seed must be a whole number from 0, not ''"),
        ("demo:?seed=-1", "seed must be 0 or more, not -1"),
        ("demo:?seed=1&seed=2", "option seed is given twice"),
        ("demo:?fps=0", "fps must lie in 1 to 1000, not 0"),
        ("demo:?fps=fast", "option fps must be a number, 1 to 1000, not 'fast'"),
        ("demo:?noise=nan", "noise must lie in 0 to 1, not nan"),
        ("demo:?noise_kind=pink", "noise_kind must be white or kinect, not 'pink'"),
        ("demo:?seconds=-3", "seconds must be a positive number, not -3"),
        ("demo:?performers=0", "performers must lie in 1 to 64, not 0"),
        ("demo:?performers=2&performer=anna", "performer names a single performer, not 2"),
        ("demo:?moves=rest,fly", "no move is called 'fly'; there are rest, walk"),
        ("demo:?moves=", "no move is called ''"),
        ("demo://host", "is not of the form demo: or demo:"),
        ("demo:seed=3", "is not of the form demo: or demo:"),
    ],
)
def test_wrong_urls_are_refused_in_one_line(url, message):
    with pytest.raises(SettingsError, match=message) as caught:
        DemoSource.from_url(url, speed="max")
    assert "\n" not in str(caught.value)


def test_impossible_speed_is_misuse():
    with pytest.raises(ValueError, match="speed must be a positive number"):
        DemoSource(speed=0)
