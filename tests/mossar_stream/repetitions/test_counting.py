"""Repetitions: counted causally, the same for every way of chopping, revised by later evidence."""

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mossar_adapters.demo import performance, plan
from mossar_adapters.demo.moves import squat, wave
from mossar_stream import (
    Event,
    PhaseEvent,
    RepetitionEvent,
    Segmenter,
    Settings,
    SettingsError,
    Skeleton,
    segment_recording,
    to_json,
)
from mossar_stream.repetitions.reporting import latest_repetitions
from mossar_tools.evaluation.matching import Cut, match

SHARED = Path(__file__).parents[3].parent / "shared/data/labelled"
SKELETON = Skeleton(("hip", "knee", "hand"), (-1, 0, 0))
COUNTING = Settings(repetitions=True)


def raises(periods: list[float], fps: float = 30.0, rest: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return a hand that rests, goes up and down once for each period, and rests; and times."""
    rate = int(1000 / 1)
    wave = [np.zeros(int(rest * rate))]
    wave += [0.5 - 0.5 * np.cos(np.linspace(0, 2 * np.pi, int(p * rate), endpoint=False)) for p in periods]
    curve = np.concatenate([*wave, np.zeros(int(rest * rate))])
    times = np.arange(int(len(curve) / rate * fps)) / fps
    positions = np.zeros((len(times), 3, 3), np.float32)
    positions[:, 2, 1] = 0.6 * curve[(times * rate).astype(int)]
    positions[:, 2, 0] = 0.2 * curve[(times * rate).astype(int)] ** 2
    return positions, times


def counted(events: list[Event]) -> list[RepetitionEvent]:
    return [event for event in events if isinstance(event, RepetitionEvent)]


def pushed(positions: np.ndarray, times: np.ndarray, size: int, settings: Settings = COUNTING) -> list[Event]:
    segmenter = Segmenter(SKELETON, settings)
    events: list[Event] = []
    for i in range(0, len(times), size):
        if size == 1:
            events += segmenter.push(positions[i], float(times[i]))
        else:
            events += segmenter.push(positions[i : i + size], times[i : i + size])
    return events + segmenter.end_take()


@pytest.mark.filterwarnings("ignore:performer p1 is:UserWarning")
@pytest.mark.parametrize("joint", [0, 2])
@pytest.mark.parametrize("far", [np.inf, 1e38, 2e6])
@pytest.mark.parametrize("at", [0, 100])
def test_a_coordinate_that_is_no_position_counts_as_missing(at: int, far: float, joint: int) -> None:
    """Its square leaves nothing of a pose: in a take's first frame, nothing was counted, and its snapshot was refused."""
    positions, times = raises([1.2] * 6)
    spoilt, missing = positions.copy(), positions.copy()
    spoilt[at, joint], missing[at, joint] = far, np.nan
    assert len(latest_repetitions(pushed(missing, times, 7))) == 6
    assert [to_json(e) for e in counted(pushed(spoilt, times, 7))] == [
        to_json(e) for e in counted(pushed(missing, times, 7))
    ]
    segmenter = Segmenter(SKELETON, COUNTING)
    segmenter.push(spoilt[:150], times[:150])
    blob = segmenter.snapshot()
    assert Segmenter.restore(blob).snapshot() == blob


def test_ten_raises_of_the_hand_are_ten() -> None:
    events = counted(pushed(*raises([1.5] * 10), 64))
    assert events[-1].total == 10
    assert events[-1].joint == "hand"
    assert events[-1].amplitude == pytest.approx(0.36, rel=0.15)  # 0.63 m of one joint in three


@pytest.mark.parametrize("periods", [[1.5] * 10, [1.1, 1.9] * 6])
def test_the_total_of_each_message_is_the_count_so_far(periods: list[float]) -> None:
    standing: set[str] = set()
    told = counted(pushed(*raises(periods), 64))
    assert max(event.rev for event in told) > 1, "none was told again"
    for event in told:
        (standing.discard if event.status == "withdrawn" else standing.add)(event.id)
        assert event.total == len(standing)


def test_the_tempo_is_right_within_three_percent_from_the_second_cycle() -> None:
    for event in latest_repetitions(pushed(*raises([1.3] * 12), 7)):
        if event.count >= 2:
            assert event.period == pytest.approx(1.3, rel=0.03)
            assert event.tempo == pytest.approx(60 / 1.3, rel=0.03)
        elif event.status == "counted":
            assert event.period is None


def test_a_change_of_tempo_is_followed_within_three_cycles() -> None:
    events = counted(pushed(*raises([1.0] * 8 + [1.6] * 8), 64))
    last = {event.id: event for event in events if event.status == "counted"}
    slow = [
        event for event in last.values() if event.start is not None and event.start > 1 + 8 + 3 * 1.6 - 0.3
    ]
    assert slow
    for event in slow:
        assert event.period == pytest.approx(1.6, rel=0.03)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("tempo", [1.0, 0.7])
def test_the_tempo_of_the_performer_is_said_after_two_cycles_and_right(
    monkeypatch: pytest.MonkeyPatch, seed: int, tempo: float
) -> None:
    monkeypatch.setattr(plan, "_PACES", (0.9, 0.9))
    monkeypatch.setitem(plan.REPEATED, "squat", (squat, 12, 12))
    shown = performance(seed, fps=60.0, moves=("rest", "squat", "rest"), tempo=tempo)
    period, begin = 1.08 * 0.9 / tempo, shown.cuts[0].time
    segmenter = Segmenter(shown.skeleton, COUNTING, fps=60.0)
    events = counted([*segmenter.push(shown.frames), *segmenter.end_take()])
    timed = [event for event in events if event.tempo is not None]
    assert timed[0].count == 2
    assert timed[0].decided_time < begin + 2 * period + 1.1  # the next look, at most a second later
    assert timed[0].tempo == pytest.approx(60 / period, rel=0.06)  # of a cycle that may not be over
    for event in (event for event in latest_repetitions(timed) if event.tempo):
        assert event.tempo == pytest.approx(60 / period, rel=0.03)
    assert events[-1].total == pytest.approx(12, abs=1)


def test_a_change_of_the_performers_tempo_is_followed_within_three_cycles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(plan, "_PACES", (0.9, 0.9))
    monkeypatch.setitem(plan.REPEATED, "squat", (squat, 16, 16))
    shown = performance(2, fps=60.0, moves=("rest", "squat", "rest"))
    quick, begin = 1.08 * 0.9, shown.cuts[0].time
    slower_from = begin + 8 * quick
    times = shown.frames.times + 0.5 * np.maximum(shown.frames.times - slower_from, 0.0)  # 1.5 times as slow
    segmenter = Segmenter(shown.skeleton, COUNTING)
    events = counted([*segmenter.push(shown.frames.positions, times), *segmenter.end_take()])
    last = {event.id: event for event in events}
    known = [event for event in last.values() if event.period is not None and event.start is not None]
    before = [event.period for event in known if event.start < slower_from - quick]
    after = [event.period for event in known if event.start > slower_from + 2.5 * 1.5 * quick]
    assert len(before) >= 5
    assert len(after) >= 3
    assert before == pytest.approx([quick] * len(before), rel=0.03)
    assert after == pytest.approx([1.5 * quick] * len(after), rel=0.03)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_the_tempo_of_fast_movements_is_right_as_said_last(
    monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    monkeypatch.setattr(plan, "_PACES", (0.9, 0.9))
    monkeypatch.setitem(plan.REPEATED, "wave", (wave, 16, 16))
    shown = performance(seed, fps=30.0, moves=("rest", "wave", "rest"))
    segmenter = Segmenter(shown.skeleton, COUNTING, fps=30.0)
    events = counted([*segmenter.push(shown.frames), *segmenter.end_take()])
    periods = [event.period for event in events if event.period is not None]
    assert np.median(periods) == pytest.approx(0.45, rel=0.01)
    last = [event.period for event in latest_repetitions(events) if event.period is not None]
    assert len(last) >= 13
    assert last == pytest.approx([0.45] * len(last), rel=0.03)


def test_limbs_are_counted_apart() -> None:
    positions, times = raises([1.4] * 8)
    both = Settings(repetitions=True, limbs="arm=hand;leg=knee")
    events = pushed(positions, times, 1, both)
    body = [event for event in counted(events) if event.channel == "body"]
    arm = [event for event in counted(events) if event.channel == "arm"]
    assert body == counted(pushed(positions, times, 1))
    assert {event.channel for event in counted(events)} == {"body", "arm"}  # the leg is still
    assert arm[-1].total == 8
    assert arm[0].id == "p1/arm/0/r1"
    assert arm[-1].joint == "hand"
    assert [to_json(event) for event in pushed(positions, times, 64, both)] == [
        to_json(event) for event in events
    ]
    result = segment_recording(positions, 30, SKELETON, both, times=times)
    assert len(result.limbs["arm"].repetitions) == 8
    assert result.limbs["leg"].repetitions == []


def test_limbs_are_counted_on_after_a_snapshot_and_until_they_are_not_wanted() -> None:
    positions, times = raises([1.4] * 8)
    both = Settings(repetitions=True, limbs="arm=hand;leg=knee")
    segmenter, events = Segmenter(SKELETON, both), []
    for i in range(len(times)):
        events += segmenter.push(positions[i], float(times[i]))
        if i % 50 == 0:
            segmenter = Segmenter.restore(segmenter.snapshot())
    assert [to_json(e) for e in events + segmenter.end_take()] == [
        to_json(e) for e in pushed(positions, times, 1, both)
    ]
    segmenter = Segmenter(SKELETON, both)
    segmenter.push(positions[:200], times[:200])
    segmenter.change(repetitions=False)
    assert not counted([*segmenter.push(positions[200:], times[200:]), *segmenter.end_take()])


def test_where_repetitions_begin_is_decided_for_the_whole_bout() -> None:
    """The take begins in the middle of a raise; limbs hang down straight where the movement begins."""
    rest, top = np.float32([[0, -0.3, 0], [0, -0.6, 0]]), np.float32([[0, -0.3, 0], [0.3, -0.3, 0]])
    skeleton = Skeleton(("hips", "elbow", "wrist"), (-1, 0, 1))
    times = np.arange(0, 16, 1 / 30)
    share = (0.5 + 0.5 * np.cos(2 * np.pi * times / 1.6)).astype(np.float32)[:, None, None]  # bent at first
    positions = np.concatenate(
        [np.zeros((len(times), 1, 3), np.float32), rest + share * (top - rest)], axis=1
    )
    segmenter = Segmenter(skeleton, COUNTING)
    events = counted([*segmenter.push(positions, times), *segmenter.end_take()])
    last = {event.id: event for event in events if event.status == "counted"}
    begins = [event.start for event in last.values()][1:]
    straight = [0.8 + 1.6 * k for k in range(10)]
    assert all(min(abs(begin - time) for time in straight) < 0.15 for begin in begins)


def test_where_limbs_are_as_straight_repetitions_begin_where_they_are_upright() -> None:
    """A straight arm is raised to the front, again and again; the take begins with it raised."""
    skeleton = Skeleton(("hips", "elbow", "wrist"), (-1, 0, 1))
    times = np.arange(0, 16, 1 / 30)
    angle = np.pi / 2 * (0.5 + 0.5 * np.cos(2 * np.pi * times / 1.6))
    arm = np.stack([np.zeros_like(angle), -np.cos(angle), np.sin(angle)], axis=-1)
    positions = (arm[:, None] * np.array([0.0, 0.3, 0.6])[:, None]).astype(np.float32)
    segmenter = Segmenter(skeleton, COUNTING)
    events = counted([*segmenter.push(positions, times), *segmenter.end_take()])
    begins = [event.start for event in {event.id: event for event in events}.values()][1:]
    assert len(begins) >= 8
    assert all(abs((begin - 0.8 + 0.8) % 1.6 - 0.8) < 0.15 for begin in begins)


def test_one_movement_is_no_repetition() -> None:
    assert counted(pushed(*raises([1.5]), 64)) == []


@pytest.mark.parametrize("size", [7, 64, 10_000])
def test_chunks_do_not_matter(size: int) -> None:
    positions, times = raises([1.2, 1.3, 1.1, 1.2, 2.0, 1.9, 1.2])
    positions[40:44, 2] = np.nan
    times[100:] += 3.0  # another take
    one = pushed(positions, times, 1)
    assert [to_json(event) for event in pushed(positions, times, size)] == [to_json(event) for event in one]


def test_a_gap_of_a_year_is_passed_over() -> None:
    positions, times = raises([1.2] * 6)
    late = times + np.where(times > 5.0, 3e7, 0.0)
    found = segment_recording(positions, 30, SKELETON, COUNTING, times=late).repetitions
    assert 4 <= len(found) <= 6
    assert all(event.end - event.start < 3.0 for event in found if event.end and event.start)


@pytest.mark.parametrize("seed", [3, 4, 7])
def test_several_looks_at_once_after_a_gap_are_told_of_together(seed: int) -> None:
    shown = performance(seed, fps=30.0, seconds=30)
    times = shown.frames.times + np.where(shown.frames.times > 20, 3.0, 0.0)
    found = segment_recording(shown.frames.positions, 30, shown.skeleton, COUNTING, times=times).repetitions
    assert len(found) > 8
    assert all(event.period is None or event.period > 0.3 for event in found)
    segmenter = Segmenter(shown.skeleton, COUNTING.replace(max_pause=10.0))
    events = segmenter.push(shown.frames.positions, times) + segmenter.end_take()
    assert [(e.start, e.end, e.period) for e in latest_repetitions(events)] == [
        (e.start, e.end, e.period) for e in found
    ]


def test_who_stands_before_a_noisy_sensor_repeats_nothing() -> None:
    shown = performance(1, fps=30.0, noise=0.005, seconds=20, moves=("stand:40",))
    positions = np.asarray(shown.frames.positions, np.float32)
    assert len(positions) == 600
    assert segment_recording(positions, 30, shown.skeleton, COUNTING).repetitions == []


def test_key_frames_and_segments_are_the_same_with_and_without() -> None:
    frames = raises([1.2] * 6)
    without = [to_json(event) for event in pushed(*frames, 16, Settings())]
    events = pushed(*frames, 16)
    assert counted(events)
    assert [to_json(event) for event in events if not isinstance(event, RepetitionEvent)] == without


def test_a_snapshot_goes_on_where_it_was() -> None:
    positions, times = raises([1.2] * 8)
    segmenter, events = Segmenter(SKELETON, COUNTING), []
    for i in range(len(times)):
        events += segmenter.push(positions[i], float(times[i]))
        if i % 50 == 0:
            segmenter = Segmenter.restore(segmenter.snapshot())
    assert [to_json(e) for e in events + segmenter.end_take()] == [
        to_json(e) for e in pushed(positions, times, 1)
    ]


def test_the_phase_runs_from_zero_to_one_once_a_cycle() -> None:
    positions, times = raises([1.2] * 10)
    segmenter, phases = Segmenter(SKELETON, COUNTING), []
    for i in range(len(times)):
        segmenter.push(positions[i], float(times[i]))
        phases.append((float(times[i]), segmenter.phase))
    known = [(t, phase) for t, phase in phases if phase is not None and t < 1 + 12 - 0.1]
    assert known
    assert phases[10][1] is None
    apart = [abs((phase - (t - 1) / 1.2 + 0.5) % 1 - 0.5) for t, phase in known]
    assert np.median(apart) < 0.1


def told_phases(size: int) -> list[tuple[float, float | None]]:
    positions, times = raises([1.2] * 6, rest=4.0)
    positions, times = positions[90:], times[90:]
    events = pushed(positions, times, size, Settings(repetitions=True, phase=True))
    return [(event.time, event.phase) for event in events if isinstance(event, PhaseEvent)]


def test_the_phase_is_told_of_each_frame_on_request() -> None:
    told = told_phases(64)
    times = [time for time, _ in told]
    assert np.diff(times) == pytest.approx(1 / 30)
    assert [phase for _, phase in told if phase is None] == [None]  # once, when it is over
    assert told[-1][1] is None
    segmenter, asked = Segmenter(SKELETON, COUNTING), []
    positions, frames = raises([1.2] * 6, rest=4.0)
    for position, time in zip(positions[90:], frames[90:].tolist(), strict=True):
        segmenter.push(position, time)
        asked.append((time, segmenter.phase))
    assert told[:-1] == [pair for pair in asked if pair[1] is not None]
    assert told_phases(1) == told_phases(7) == told


def test_the_phase_needs_repetitions() -> None:
    with pytest.raises(SettingsError, match="phase needs repetitions"):
        Settings(phase=True)


def test_halves_of_a_movement_are_one() -> None:
    """Left and right in turn are one repetition, seen by what they have in common."""
    positions, times = raises([0.9] * 16)
    odd = (((times - 1) // 0.9) % 2 == 1)[:, None]
    positions[:, 1] = np.where(odd, positions[:, 2] * (-1.0, 0.8, 0.5), 0.0)
    positions[:, 2] = np.where(odd, positions[:, 2] * 0.3, positions[:, 2])
    assert counted(pushed(positions, times, 64))[-1].total == pytest.approx(8, abs=1)


def test_a_recording_has_its_repetitions() -> None:
    positions, times = raises([1.5] * 6)
    result = segment_recording(positions, 30, SKELETON, COUNTING, times=times)
    assert [event.count for event in result.repetitions] == [1, 2, 3, 4, 5, 6]
    assert segment_recording(positions, 30, SKELETON, times=times).repetitions == []


@pytest.mark.parametrize(("folder", "most"), [("precog", 0), ("vmci", 1)])
def test_what_is_no_exercise_is_not_counted(folder: str, most: int) -> None:
    paths = sorted((SHARED / folder).glob("*.json"))
    if not paths:
        pytest.skip(f"../shared/data/labelled/{folder} is not there")
    totals = []
    for path in paths:
        take = np.load(path.parent / json.loads(path.read_text())["recording"])
        skeleton = Skeleton(tuple(map(str, take["joint_names"])), tuple(map(int, take["parents"])))
        positions = np.asarray(take["positions"], np.float32)
        result = segment_recording(positions, float(take["fps"]), skeleton, COUNTING)
        totals.append(len(result.repetitions))
    assert sum(totals) <= most


def ends_in(events: list[RepetitionEvent]) -> list[float]:
    """Return where repetitions begin and end, s, an end and a near begin as one."""
    found: list[float] = []
    for event in events:
        for time in (event.start, event.end):
            if time is not None and (not found or time - found[-1] > 0.3):
                found.append(time)
    return found


def labelled(folder: Path) -> list[tuple[np.ndarray, float, Skeleton, dict[str, Any]]]:
    """Return positions, rate, skeleton and labels of the takes of a folder."""
    paths = sorted(folder.glob("*.json"))
    if not paths:
        pytest.skip(f"../shared/data/{folder.name} is not there")
    takes = []
    for path in paths:
        labels = json.loads(path.read_text())
        take = np.load(path.parent / labels["recording"])
        skeleton = Skeleton(tuple(map(str, take["joint_names"])), tuple(map(int, take["parents"])))
        takes.append((np.asarray(take["positions"], np.float32), float(take["fps"]), skeleton, labels))
    return takes


def test_exercises_are_counted() -> None:
    errors, shares, scores = [], [], []
    for positions, fps, skeleton, labels in labelled(SHARED / "ui_prmd"):
        segmenter = Segmenter(skeleton, COUNTING, fps=fps)
        events = latest_repetitions(segmenter.push(positions) + segmenter.end_take())
        errors.append(abs(len(events) - labels["repetitions"]))
        shares.append(errors[-1] / labels["repetitions"])
        cuts = [Cut(*(frame / fps for frame in cut)) for cut in labels["cuts"]]
        ends = ends_in(events)[1:-1]  # labels have no cut where a take begins or ends
        hits = match(ends, cuts, labels["tolerance_s"])
        scores.append(2 * len(hits) / max(1, len(ends) + len(cuts)))
    assert np.mean(np.array(errors) <= 1) >= 0.98
    assert np.mean(np.array(errors) == 0) >= 0.96
    assert np.mean(shares) <= 0.007
    assert np.mean(scores) >= 0.95


def rising(events: list[RepetitionEvent]) -> bool:
    """Return whether each repetition ends after it began, and begins where the one before ended, or later."""
    spans = [(event.start, event.end) for event in latest_repetitions(events) if event.start and event.end]
    times = [time for span in spans for time in span]
    return all(a < b for a, b in spans) and all(a <= b + 1e-9 for a, b in itertools.pairwise(times))


def odd_series(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return poses and times of movements of all sizes and paces, of leaps, rests, gaps and noise, in turns."""
    rng = np.random.default_rng(seed)
    parts, last = [], np.zeros((3, 3))
    for _ in range(rng.integers(3, 9)):
        n, cycles = int(rng.integers(5, 200)), rng.integers(0, 8)
        wave = np.sin(np.linspace(0, 2 * np.pi * cycles, n))[:, None, None] ** rng.integers(1, 4)
        part = last + wave * rng.normal(0, rng.choice([0.001, 0.05, 0.5]), (3, 3))
        part += rng.normal(0, rng.choice([0.0, 0.0005, 0.01]), part.shape)
        if rng.random() < 0.3:
            part[:, rng.integers(3)] = np.nan
        parts.append(part)
        last = rng.normal(0, 0.3, (3, 3)) if rng.random() < 0.3 else np.nan_to_num(part[-1])
    positions = np.concatenate(parts).astype(np.float32)
    return positions, np.cumsum(rng.choice([1 / 120, 1 / 30, 1 / 30, 0.2], len(positions)))


@pytest.mark.parametrize("first", range(0, 200, 50))
def test_starts_and_ends_rise_whatever_comes(first: int) -> None:
    found = 0
    for seed in range(first, first + 50):
        events = counted(pushed(*odd_series(seed), 64, COUNTING.replace(limbs="arm=hand;leg=knee")))
        for channel in ("body", "arm", "leg"):
            own = [event for event in events if event.channel == channel]
            assert rising(own), (seed, channel)
            found += len(own)
            for before, event in itertools.pairwise(own):
                assert event.total >= before.total or event.status == "withdrawn"
    assert found > 20


@pytest.mark.parametrize("seed", range(6))
def test_starts_and_ends_rise_for_a_performer_who_waves_and_squats(seed: int) -> None:
    shown = performance(seed, fps=30.0, seconds=15, moves=("wave_left", "squat", "rest:0.5") * 6)
    segmenter = Segmenter(shown.skeleton, COUNTING.replace(limbs=True), fps=30.0)
    events = counted([*segmenter.push(shown.frames), *segmenter.end_take()])
    assert events
    for channel in {event.channel for event in events}:
        assert rising([event for event in events if event.channel == channel])


@pytest.mark.parametrize("fps", [30.0, 120.0])
@pytest.mark.parametrize(("period", "times"), [(0.4, 5), (0.7, 3), (1.0, 3), (8.0, 3)])
def test_series_that_are_short_are_counted_at_any_tempo(period: float, times: int, fps: float) -> None:
    events = latest_repetitions(pushed(*raises([period] * times, fps), 64))
    assert len(events) == times
    for number, event in enumerate(events):
        assert event.end == pytest.approx(1.0 + period * (number + 1), abs=max(0.15, 0.2 * period))


@pytest.mark.parametrize("period", [0.5, 0.7, 1.0])
def test_series_without_a_rest_around_them_are_counted(period: float) -> None:
    positions, times = raises([period] * 3, rest=0.0)
    assert len(latest_repetitions(pushed(positions, times, 64))) == 3
    begun = int(0.3 * period * 30)  # in the midst of a movement
    rolled = np.roll(positions[: int(3 * period * 30)], begun, axis=0)
    assert len(latest_repetitions(pushed(rolled, times[: len(rolled)], 64))) == 3


@pytest.mark.parametrize("lasts", [0.2, 0.4, 0.6])
def test_a_joint_that_the_sensor_misplaces_for_a_while_changes_no_count(lasts: float) -> None:
    """It adds samples to the first of three repetitions, which takes as long as the others."""
    positions, times = raises([8.0] * 3)
    shaken = (times > 4.0) & (times < 6.0)
    positions[shaken, 1, 2] += 0.1 * np.abs(np.sin(np.pi * times[shaken] / lasts))
    assert len(latest_repetitions(pushed(positions, times, len(times)))) == 3


@pytest.mark.parametrize("noise", [0.0, 0.002, 0.004])
def test_a_pause_changes_no_count(noise: float) -> None:
    positions, _ = raises([1.5] * 10)
    middle = 30 + 5 * 45
    pause = np.repeat(positions[middle : middle + 1], 360, axis=0)
    pause = pause + np.random.default_rng(1).normal(0.0, noise, pause.shape)
    held = np.concatenate([positions[:middle], pause, positions[middle:]]).astype(np.float32)
    events = counted(pushed(held, np.arange(len(held)) / 30, 64))
    assert events[-1].total == 10
    assert [event.status for event in events].count("withdrawn") == 0


def test_who_sways_before_a_series_is_not_counted() -> None:
    large, _ = raises([1.5] * 4)
    sway = np.zeros((600, 3, 3), np.float32)
    sway[:, 2, 0] = 0.0007 * np.sin(2 * np.pi * np.arange(600) / 30)
    positions = np.concatenate([sway, large])
    positions[:, 1, 1] -= 0.5  # a leg: how large who stands there is
    events = latest_repetitions(pushed(positions, np.arange(len(positions)) / 30, 64))
    assert len(events) == 4
    assert all(event.amplitude is not None and event.amplitude > 0.1 for event in events)


def test_poses_that_are_stretched_frame_by_frame_are_survived() -> None:
    for positions, fps, skeleton, _ in labelled(SHARED.parent / "stretched_repcount")[::8]:
        segmenter = Segmenter(skeleton, COUNTING, fps=fps)
        for event in latest_repetitions(segmenter.push(positions) + segmenter.end_take()):
            assert event.start is not None
            assert event.end is not None
            assert event.start < event.end


def test_where_the_clock_began_does_not_decide_when_repetitions_are_looked_at():
    take = performance(8, fps=30.0, seconds=20.0)
    positions, times = np.array(take.frames.positions), np.arange(len(take.frames.times)) / 30
    found = []
    for offset in (0.0, 60.0, 240.0, 3600.0):
        events = Segmenter(take.skeleton, COUNTING).push(positions, times + offset)
        found.append(
            [
                (e.id, e.status, round(e.decided_time - offset, 3))
                for e in events
                if isinstance(e, RepetitionEvent)
            ]
        )
    assert len(found[0]) > 30
    assert found[0] == found[1] == found[2] == found[3]
