"""Ours beside others: one runner for all."""

import msgspec.structs
import numpy as np
import pytest

from checks.paper.velocity_based import velocity
from checks.peers.feeds import PositionFeed, feed_of
from checks.peers.ours import MossarDetector, in_chunks, one_by_one
from checks.peers.results import Result, conclusions, result_lines, usable_peers
from checks.peers.runner import run_peer, run_take
from checks.peers.table import PEERS
from mossar_adapters.extras import installed
from mossar_stream import MossarError, Settings
from mossar_tools.evaluation.mossar import at_level_of, stream
from mossar_tools.evaluation.performer import demo_takes


@pytest.fixture(scope="module")
def takes():
    return list(demo_takes("demo:?fps=30&seconds=12", 1))


def test_ours_one_by_one_is_ours_in_chunks(takes):
    own = run_take(MossarDetector(takes[0]), PositionFeed(), takes[0])
    assert own.found.times == stream(takes[0], Settings(), "final").times
    assert len(own.waits) == len(takes[0].times)
    assert one_by_one(takes).scores.f1 == in_chunks(takes).scores.f1 > 0.4


class Alternating:
    """Decides at every second frame that there was a cut one frame before."""

    count = 0

    def update(self, _, time):
        self.count += 1
        return [time - 1 / 30] if self.count % 2 == 0 else []

    def finish(self):
        return [0.0]


def test_cuts_are_kept_with_the_time_of_their_decision(takes):
    short = msgspec.structs.replace(takes[0], positions=takes[0].positions[:6], times=np.arange(6) / 30)
    found = run_take(Alternating(), PositionFeed(), short).found
    assert found.times == pytest.approx([0, 0, 2 / 30, 4 / 30])
    assert sorted(found.decided) == pytest.approx([1 / 30, 3 / 30, 5 / 30, 5 / 30])


@pytest.mark.parametrize(("name", "shape"), [("curve", (1,)), ("poses", (63,)), ("positions", (21, 3))])
def test_peers_are_fed_every_frame_in_its_shape(takes, name, shape):
    feed = feed_of(name, takes[0])
    assert feed.sample(takes[0].positions[0], 0.0).shape == shape
    assert np.isfinite(feed.sample(np.full((21, 3), np.nan, np.float32), 0.1)).all() == (name != "positions")


def test_the_curve_that_peers_are_fed_is_that_of_equation_1(takes):
    feed = feed_of("curve", takes[0])
    plain = [float(feed.sample(*frame)[0]) for frame in zip(takes[0].positions, takes[0].times, strict=True)]
    times, curve = velocity(takes[0], Settings(noise_margin=0.0))
    window = at_level_of(takes[0], Settings(similarity="likelihood")).resolved().window
    assert len(times) == len(plain)
    assert plain == pytest.approx(curve / window / len(takes[0].skeleton), abs=1e-3)


@pytest.mark.parametrize("peer", PEERS, ids=[peer.library + " " + peer.name for peer in PEERS])
def test_every_peer_that_is_installed_goes_through_a_take(takes, peer):
    if not installed(peer.library):
        pytest.skip(f"{peer.library} is not installed")
    own = run_peer(takes, peer, peer.best["motion"])
    assert own.frames == 360
    assert 0 <= own.scores.f1 <= 1


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
def test_the_settings_of_every_peer_are_among_those_that_were_tried(peer):
    assert set(peer.best) == {"motion", "cluster"}
    for chosen in peer.best.values():
        assert all(value in peer.grid[name] for name, value in chosen.items())
        assert set(chosen) == set(peer.grid)


def test_without_any_peer_one_line_says_what_to_install():
    if any(installed(peer.library) for peer in PEERS):
        assert usable_peers()[0]
        return
    with pytest.raises(MossarError, match=r"pip install 'mossar-stream\[peers\]'"):
        usable_peers()


def test_the_table_says_whether_ours_is_ahead():
    def row(name, rate, f1, knows=""):
        return Result(name, "motion", (rate,), rate, "wall", f1, 1.0, 2.0, 3.0, "", knows)

    rows = [
        row("mossar-stream, frame by frame", 1e5, 0.8),
        row("quick", 2e4, 0.6),
        row("oracle", 1.0, 0.9, "all"),
    ]
    said = list(conclusions(rows))
    assert said == [
        "F1 0.80, the best peer 0.60 (quick): ahead",
        "mossar-stream, frame by frame: 5.0 times the throughput of quick (>= 10: missed)",
    ]
    assert any(line.startswith("oracle*") for line in result_lines(rows))
