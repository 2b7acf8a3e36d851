import json
import struct

import numpy as np
import pytest

from mossar_adapters.files import open_recording, read
from mossar_adapters.files.options import ReadOptions

COUNT, JOINTS = 400, 3
FORMS = ("csv", "maps", "npz", "poses", "osc")


def float32(value):
    return struct.unpack("f", struct.pack("f", value))[0]


# Seconds that passed: what the file says.
CLOCKS = {
    "unix_float32": lambda t: float32(1655161200 + t),
    "still": lambda _: 7.0,
    "whole_seconds": lambda t: float(int(t + 0.37)),
    "quarter_seconds": lambda t: int((t + 0.1) * 4) / 4,
}


def moving():
    noise = np.random.default_rng(3).normal(scale=0.01, size=(COUNT, JOINTS, 3))
    return np.array([[0.0, 1.0, 0.0], [0.1, 1.7, 0.0], [0.2, 0.1, 0.0]]) + noise


def written(path, form, times, positions):
    """Write a recording, and return its path."""
    names = ("hips", "head", "foot")
    path = path / f"take.{ {'maps': 'jsonl', 'poses': 'jsonl'}.get(form, form) }"
    if form == "csv":
        rows = ["time," + ",".join(f"{name}.{axis}" for name in names for axis in "xyz")]
        rows += [
            ",".join(map(repr, [t, *pose.ravel().tolist()])) for t, pose in zip(times, positions, strict=True)
        ]
        path.write_text("\n".join(rows) + "\n")
    elif form == "npz":
        np.savez(path, positions=positions, times=np.array(times), joint_names=np.array(names))
    elif form == "osc":
        rows = []
        for k, (t, pose) in enumerate(zip(times, positions, strict=True)):
            stamp = f"{0xE8754700 + k // 60:08x}.{int(k % 60 / 60 * 2**32):08x}"
            rows += [
                f'{stamp} /VMC/Ext/Bone/Pos sfffffff "{bone}" {x:.6f} {y:.6f} {z:.6f} 0.0 0.0 0.0 1.0'
                for bone, (x, y, z) in zip(("Hips", "Spine", "Head"), pose, strict=True)
            ]
            rows.append(f"{stamp} /VMC/Ext/T f {t:.6f}")
        path.write_text("\n".join(rows) + "\n")
    else:
        rows = []
        for t, pose in zip(times, positions, strict=True):
            points = pose.tolist()
            found = {"t": t, "joints": dict(zip(names, points, strict=True))}
            rows.append(found if form == "poses" else {"type": "frame", "t": t, "xyz": points})
        path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return path


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", CLOCKS)
def test_frames_are_counted_where_the_times_do_not_run(tmp_path, form, name):
    path = written(tmp_path, form, [CLOCKS[name](k / 60) for k in range(COUNT)], moving())
    recording = open_recording(path)
    times = read(path).times
    assert len(times) == COUNT
    if form == "osc":  # the log has stamps
        assert np.diff(times) == pytest.approx(1 / 60, abs=0.005)
        assert any("stands still" in note or "steps" in note for note in recording.notes)
        return
    rate = 60.0 if "seconds" in name else 30.0
    assert np.diff(times) == pytest.approx(1 / rate, abs=1e-6)
    assert recording.fps == rate
    assert sum("its times stand still or step coarsely" in note for note in recording.notes) == 1


@pytest.mark.parametrize("form", FORMS)
def test_the_rate_of_the_user_takes_precedence(tmp_path, form):
    path = written(tmp_path, form, [7.0] * COUNT, moving())
    assert np.diff(read(path, fps=50.0).times) == pytest.approx(1 / 50)
    assert not [note for note in open_recording(path, ReadOptions(fps=50.0)).notes if "still" in note]


@pytest.mark.parametrize("form", ["csv", "maps", "npz", "poses"])
@pytest.mark.parametrize(("per_second", "name"), [(1e3, "ms"), (1e6, "µs"), (1e9, "ns")])
@pytest.mark.parametrize("begin", [0.0, 1.7e9])
def test_times_in_another_unit_are_read_in_it(tmp_path, form, per_second, name, begin):
    path = written(tmp_path, form, [round((begin + k / 60) * per_second) for k in range(COUNT)], moving())
    recording = open_recording(path)
    assert np.diff(read(path).times) == pytest.approx(1 / 60, abs=1e-3)
    assert read(path).times[0] == pytest.approx(begin, abs=1e-3)
    assert f"times taken as {name}" in recording.notes
    assert recording.fps == pytest.approx(60.0, rel=0.01)


@pytest.mark.parametrize("form", ["csv", "maps", "npz", "poses"])
@pytest.mark.parametrize(
    ("clock", "why"),
    [
        (lambda k: k, "its times are frame numbers"),
        (lambda k: 1000 + k, "its times are frame numbers"),
        (lambda k: 45000 + k / 60 / 86400, "its times step by 1.93e-07 s"),  # days, as in spreadsheets
        (lambda k: k / 60 / 60, "its times step by 0.000278 s"),  # minutes
    ],
)
def test_frames_are_counted_where_no_frames_have_such_times(tmp_path, form, clock, why):
    path = written(tmp_path, form, [clock(k) for k in range(COUNT)], moving())
    recording = open_recording(path)
    assert np.diff(read(path).times) == pytest.approx(1 / 30, abs=1e-6)
    assert recording.fps == 30.0
    assert [note for note in recording.notes if why in note and "set --fps" in note]
    assert np.diff(read(path, fps=50.0).times) == pytest.approx(1 / 50)


@pytest.mark.parametrize("form", ["csv", "maps", "npz", "poses"])
@pytest.mark.parametrize("since", [621_355_968_000_000_000, 116_444_736_000_000_000])  # the year 1, and 1601
def test_dates_in_ticks_of_100_ns_are_read(tmp_path, form, since):
    ticks = [since + round((1.7e9 + k / 60) * 1e7) for k in range(COUNT)]
    path = written(tmp_path, form, ticks, moving())
    assert np.diff(read(path).times) == pytest.approx(1 / 60, abs=2e-5)
    assert "times taken as 100 ns" in open_recording(path).notes


@pytest.mark.parametrize("form", ["csv", "maps", "npz", "poses"])
@pytest.mark.parametrize("fps", [15, 30, 60])
def test_ticks_of_100_ns_since_the_start_are_read(tmp_path, form, fps):
    path = written(tmp_path, form, [round(k / fps * 1e7) for k in range(COUNT)], moving())
    assert np.diff(read(path).times) == pytest.approx(1 / fps, abs=2e-7)
    assert "times taken as 100 ns" in open_recording(path).notes


def test_poses_whose_clock_was_set_back_are_counted_at_the_rate_of_its_steps(tmp_path):
    path = written(tmp_path, "poses", [k % 200 / 60 for k in range(COUNT)], moving())
    assert np.diff(read(path).times) == pytest.approx(1 / 60)
    assert any("do not increase" in note and "60 Hz" in note for note in open_recording(path).notes)


@pytest.mark.parametrize("form", ["csv", "maps", "npz"])
def test_a_clock_that_stops_later_is_noticed(tmp_path, form, caplog):
    path = written(tmp_path, form, [min(k / 60, 300 / 60) for k in range(COUNT)], moving())
    times = read(path).times
    assert np.diff(times).min() > 0
    assert times[-1] == pytest.approx((COUNT - 1) / 60, abs=0.1)
    assert "its times stand still" in caplog.text


@pytest.mark.parametrize("form", ["csv", "maps", "npz"])
def test_rows_that_are_written_twice_are_no_standing_clock(tmp_path, form):
    positions = np.repeat(moving()[: COUNT // 2], 2, axis=0)
    stamps = [k // 2 / 30 for k in range(COUNT)]
    path = written(tmp_path, form, stamps, positions)
    assert read(path).times == pytest.approx(stamps, abs=1e-12)
    assert not [note for note in open_recording(path).notes if "rate" in note]


@pytest.mark.parametrize(
    ("stamps", "why"),
    [
        ([0.0, 0.1, 0.05, 0.2], "the times do not increase from frame to frame"),
        ([0.0, 0.1, None, 0.2], "1 of 4 frames have no time"),
        ([None] * 4, "the file states neither rate nor times"),
    ],
)
def test_poses_without_usable_times_say_why(tmp_path, stamps, why):
    path = written(tmp_path, "poses", stamps, moving()[:4])
    assert [why in note for note in open_recording(path).notes if "rate taken" in note] == [True]
