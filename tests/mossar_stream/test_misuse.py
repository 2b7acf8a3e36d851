"""Wrong use of segmenters and pools is said at once, and changes nothing; what people hand over is taken as it is."""

import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from mossar_stream import (
    FrameError,
    Frames,
    Performers,
    Segmenter,
    Settings,
    SettingsError,
    Skeleton,
    segment_recording,
)

SKELETON = Skeleton(("hip", "hand", "foot"), (-1, 0, 0))


def walk(count=120, seed=1):
    rng = np.random.default_rng(seed)
    return rng.normal(0, 0.02, (count, 3, 3)).cumsum(axis=0), np.arange(count) / 60


def in_threads(work, count=4):
    errors = []

    def run():
        try:
            work()
        except RuntimeError as error:
            errors.append(str(error))

    threads = [threading.Thread(target=run) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    return errors


def test_a_segmenter_used_by_two_threads_at_once_says_so():
    # Or most frames are passed over at once.
    segmenter = Segmenter(SKELETON, Settings(rate_limit=0.0), fps=60)
    positions = np.zeros((50_000, 3, 3), np.float32)
    begin, is_said = threading.Barrier(4), threading.Event()

    def work():
        begin.wait(10)
        for _ in range(100):  # a busy machine may let one thread after the other have its turn
            try:
                segmenter.push(positions, time.monotonic() + np.arange(len(positions)) / 1e5)
            except RuntimeError:
                is_said.set()
                raise
            if is_said.is_set():
                return

    errors = in_threads(work)
    assert errors
    assert all("two threads" in error for error in errors)
    segmenter.push(*walk())  # it goes on


def test_segmenters_of_their_own_run_in_threads():
    positions, times = walk(2000)
    expected = Segmenter(SKELETON).push(positions, times)

    def work():
        assert Segmenter(SKELETON).push(positions, times) == expected

    assert in_threads(work) == []


FORMS = {
    "float64": lambda p, t: (p.astype(np.float64), t),
    "not contiguous": lambda p, t: (np.asfortranarray(p), t),
    "read only": lambda p, t: (np.broadcast_to(p, p.shape), t),
    "time of numpy": lambda p, t: (p, np.float64(t)),
    "float32 time": lambda p, t: (p, np.float32(t)),
    "list": lambda p, t: (p.tolist(), t),
}


@pytest.mark.parametrize("form", FORMS)
def test_frames_in_every_usual_form_give_the_same_events(form):
    positions, _ = walk(400)
    positions = positions.astype(np.float32)
    times = np.arange(400) / 64.0  # exact in float32, too
    one, other = Segmenter(SKELETON), Segmenter(SKELETON)
    for p, t in zip(positions, times.tolist(), strict=True):
        assert one.push(p, t) == other.push(*FORMS[form](p, t))
    assert one.end_take() == other.end_take()
    assert one.stats["frames"] == 400


def test_whole_numbers_are_positions_and_times():
    segmenter = Segmenter(SKELETON, Settings(max_pause=5, max_gap=2, max_speed=100))
    for t in range(5):
        segmenter.push(np.full((3, 3), t), t)
    assert segmenter.stats["frames"] == 5
    assert segmenter.stats["out_of_order"] == 0


def test_a_person_in_millimetres_is_told_of_once():
    segmenter = Segmenter(SKELETON, performer="ann")
    positions = np.zeros((3, 3, 3))
    positions[:, 1, 1] = 1700
    with pytest.warns(UserWarning, match=r"performer ann is 1,700 m tall") as told:
        segmenter.push(positions, np.arange(3) / 30)
    assert [warning.filename for warning in told] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        segmenter.end_take()
        segmenter.push(positions, 10 + np.arange(3) / 30)


def test_a_recording_in_millimetres_is_told_of_once():
    positions = np.full((30, 3, 3), np.nan)
    positions[10:] = 0.0
    positions[10:, 1, 1] = 1700
    with pytest.warns(UserWarning, match=r"the performer is 1,700 m tall") as told:
        segment_recording(positions, 30, SKELETON, Settings(limbs=True))
    assert [warning.filename for warning in told] == [__file__]


@pytest.mark.parametrize(
    "use",
    [
        lambda level: Segmenter(SKELETON, level),
        Performers,
        lambda level: segment_recording(np.zeros((9, 3, 3)), 30, SKELETON, level),
    ],
)
def test_a_level_is_no_settings(use):
    with pytest.raises(TypeError, match=r"settings are Settings, not str; Settings\(level="):
        use("cluster")


def test_names_are_no_skeleton():
    with pytest.raises(TypeError, match="needs a Skeleton, not tuple"):
        Segmenter(("a", "b"))


def test_a_frame_number_that_the_take_had_is_refused():
    segmenter = Segmenter(SKELETON)
    positions, times = walk(20)
    segmenter.push(positions[:10], times[:10], first_frame=100)
    with pytest.raises(FrameError, match="first_frame is 105, but the take is at frame 110"):
        segmenter.push(positions[10:], times[10:], first_frame=105)
    with pytest.raises(FrameError, match="first_frame is -1"):
        segmenter.push(positions[:10], times[:10] + 100, first_frame=-1)
    segmenter.push(positions[10:], times[10:] + 100, first_frame=5)  # another take
    assert segmenter.take == 1


def test_a_level_that_is_toggled_without_frames_piles_nothing_up():
    segmenter = Segmenter(SKELETON, Settings(remerge_seconds=100, remerge_window=8))
    segmenter.push(*walk(600))
    for _ in range(1000):
        segmenter.level = 0
        segmenter.level = 1e6
    assert len(segmenter.end_take()) < 200


def test_a_refused_change_of_a_pool_changes_nothing():
    pool = Performers(Settings(similarity="path_kernel"))
    pool.announce("ann", SKELETON)
    positions, times = walk(300)
    pool.push(Frames(positions.astype(np.float32), times, performer="ann"))
    before, settings = pool.snapshot(), pool.settings
    with pytest.raises(SettingsError):
        pool.change(location="free")
    assert pool.settings == settings
    assert pool.snapshot() == before
    pool.announce("bob", SKELETON)
    assert pool.names == ("ann", "bob")


def test_a_refused_change_of_an_empty_pool_changes_nothing():
    pool = Performers(Settings(similarity="path_kernel"))
    with pytest.raises(SettingsError):
        pool.change(location="free")
    pool.announce("bob", SKELETON)


def test_a_performer_that_memory_does_not_reach_for_is_refused_and_the_others_go_on():
    pool = Performers(Settings.build("paper"), most_memory=1 << 20)
    pool.announce("ann", SKELETON)
    crowd = Skeleton(tuple(f"j{j}" for j in range(1024)), (-1, *[0] * 1023))
    with pytest.raises(FrameError, match=r"1024 joints of performer 'eve' need [\d,]+ MiB"):
        pool.announce("eve", crowd)
    assert pool.names == ("ann",)
    positions, times = walk(60)
    assert pool.push(Frames(positions.astype(np.float32), times, performer="ann"))[0].event == "started"


def test_dates_are_not_read_as_seconds():
    positions, times = walk()
    dates = np.datetime64("2026-01-01") + (times * 1e9).astype("timedelta64[ns]")
    with pytest.raises(FrameError, match=r"times are seconds, not datetime64\[ns\]"):
        Segmenter(SKELETON).push(positions, dates)


def test_a_stream_has_no_range_of_the_whole_file():
    with pytest.raises(SettingsError, match="range=file needs a whole recording"):
        Segmenter(SKELETON, Settings(range="file"))
    segmenter = Segmenter(SKELETON, fps=60)
    with pytest.raises(SettingsError, match="range=file"):
        segmenter.change(range="file")
    segmenter.push(*walk())


def test_a_recording_needs_a_skeleton_and_counts_are_whole_numbers():
    positions, _ = walk()
    with pytest.raises(TypeError, match="needs a Skeleton, not tuple"):
        segment_recording(positions, 60, ("hip", "hand", "foot"))
    result = segment_recording(positions, 60, SKELETON)
    assert result.at(count=10**20).key_frames == result.at(count=np.int64(len(result.key_frames))).key_frames
    with pytest.raises(TypeError):
        result.at(count=2.5)


SHAPES = {
    (90, 9): r"positions\.reshape\(len\(positions\), -1, 3\)",
    (90, 3): r"of one joint: positions\[:, None\]; of one frame: positions\[None\]",
    (90, 3, 2): r"np\.pad\(positions, \(\(0, 0\), \(0, 0\), \(0, 1\)\)\)",
    (90, 3, 4): r"positions\[\.\.\., :3\]",
    (4, 5, 90): r"positions\[:3\]\.transpose\(2, 1, 0\)",
}


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_positions_of_another_shape_are_refused_with_what_to_do(shape):
    with pytest.raises(FrameError, match=SHAPES[shape]):
        segment_recording(np.zeros(shape), 30)
    if shape != (90, 3):  # 90 joints of one frame for another skeleton
        with pytest.raises(FrameError, match=SHAPES[shape]):
            Segmenter(SKELETON, fps=30).push(np.zeros(shape))


def test_what_is_done_about_a_shape_helps():
    flat = np.zeros((90, 3, 2))
    assert np.pad(flat, ((0, 0), (0, 0), (0, 1))).shape == (90, 3, 3)
    assert np.zeros((4, 5, 90))[:3].transpose(2, 1, 0).shape == (90, 5, 3)


@pytest.mark.parametrize("path", ["walk.bvh", Path("walk.bvh")])
def test_a_path_is_no_array(path):
    with pytest.raises(TypeError, match=r"not the path 'walk\.bvh'; mossar_stream\.read\(path\)"):
        segment_recording(path, 30)
    with pytest.raises(TypeError, match=r"mossar_stream\.read\(path\)"):
        Segmenter(SKELETON, fps=30).push(path)


def test_a_table_is_no_array():
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame(np.zeros((30, 9)))
    with pytest.raises(TypeError, match=r"table\.to_numpy\(\)\.reshape\(len\(table\), -1, 3\)"):
        segment_recording(table, 30)
    assert segment_recording(table.to_numpy().reshape(len(table), -1, 3), 30).segments


def test_a_rate_is_a_number():
    positions, times = walk()
    for use in (
        lambda: segment_recording(positions, "60"),
        lambda: segment_recording(positions, "60", times=times),
        lambda: Segmenter(SKELETON, fps="60"),
    ):
        with pytest.raises(TypeError, match=r"fps is a number in Hz, not the text '60': float\(fps\)"):
            use()


def test_times_are_no_rate_and_a_list_of_paths_is_no_recording():
    positions, times = walk()
    for wrong in (times, list(times)):
        with pytest.raises(TypeError, match=r"not an array; the times of frames go by name: times=\.\.\."):
            segment_recording(positions, wrong)
    assert segment_recording(positions, np.float32(60)).segments
    with pytest.raises(TypeError, match=r"not the path 'walk\.bvh'; mossar_stream\.read\(path\)"):
        segment_recording(["walk.bvh"], 60)


def test_times_that_no_recording_has_are_refused():
    positions, times = walk()
    for wrong, said in (
        (np.full(120, np.nan), "all times are NaN"),
        (np.full(120, 7.0), "all 120 times are 7 s"),
        (times[::-1], r"times descend; they must rise: positions\[::-1\], times\[::-1\]"),
    ):
        with pytest.raises(FrameError, match=said):
            segment_recording(positions, times=wrong)
    assert segment_recording(positions[:1], times=[5.0]).segments


UNITS = pytest.mark.parametrize(
    ("factor", "unit"),
    [(1000, "milliseconds"), (1_000_000, "microseconds"), (1_000_000_000, "nanoseconds")],
)


@UNITS
def test_times_in_another_unit_are_reported_where_they_were_given(factor, unit):
    positions, times = walk()
    with pytest.warns(
        UserWarning, match=rf"s apart; times are seconds: times / {factor} if these are {unit}"
    ) as found:
        segment_recording(positions, times=times * factor)
    assert [warning.filename for warning in found] == [__file__]


def pushed_singly(segmenter, positions, times):
    for frame, moment in zip(positions, times, strict=True):
        segmenter.push(frame, moment)


def pushed_as_a_whole(segmenter, positions, times):
    segmenter.push(positions, times)


def pushed_to_a_pool(segmenter, positions, times):
    pool = Performers()
    pool.announce("p1", segmenter.skeleton)
    for at in range(0, len(times), 2):
        pool.push(Frames(positions[at : at + 2], times[at : at + 2], performer="p1"))


def pushed_to_a_pool_together(segmenter, positions, times):
    pool = Performers()
    pool.announce("p1", segmenter.skeleton)
    pool.push_many(["p1"], positions[None], times)


WAYS_TO_PUSH = pytest.mark.parametrize(
    "pushed", [pushed_singly, pushed_as_a_whole, pushed_to_a_pool, pushed_to_a_pool_together]
)


@UNITS
@WAYS_TO_PUSH
@pytest.mark.parametrize("begin", [0.0, 1.7e9])
def test_a_stream_in_another_unit_of_time_is_reported_once_where_it_was_pushed(pushed, begin, factor, unit):
    positions, times = walk()
    said = rf"each frame is a take of its own, as times step by .* s; times are seconds: times / {factor} if these are {unit}"
    with pytest.warns(UserWarning, match=said) as found:
        pushed(Segmenter(SKELETON), positions, (begin + times) * factor)
    assert [warning.filename for warning in found] == [__file__]


@WAYS_TO_PUSH
@pytest.mark.parametrize("begin", [0.0, 1.7e9])
def test_pauses_between_frames_in_seconds_are_not_reported(pushed, begin):
    positions, times = walk()
    pushed(Segmenter(SKELETON), positions, begin + times + 60.0 * (np.arange(len(times)) // 2))


def test_recordings_in_which_nothing_moves_are_reported():
    positions, times = walk(150)
    still = np.repeat(positions[:1], len(times), axis=0)
    hidden = np.full_like(positions, np.nan)
    hidden_at_first = still.copy()
    hidden_at_first[: len(times) // 2] = np.nan
    for wrong, said in (
        (still, "no joint moves: all frames are alike; there is nothing to segment"),
        (hidden_at_first, "no joint moves"),
        (hidden, "no joint is seen in any frame; there is nothing to segment"),
    ):
        with pytest.warns(UserWarning, match=said) as found:
            segment_recording(wrong, times=times)
        assert [warning.filename for warning in found] == [__file__]
    hidden[-1], hidden[0] = positions[-1], positions[0]
    segment_recording(hidden, times=times)
    segment_recording(still[:60], times=times[:60])  # a pose
