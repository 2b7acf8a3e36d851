import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.columns import find_columns
from mossar_adapters.files.units import height

ROWS = [
    (0.0, 0.1, 1.0, 0.2, 0.1, 1.7, 0.2),
    (0.02, 0.1, 1.0, 0.3, 0.1, 1.7, 0.3),
    (0.04, 0.1, 1.0, 0.4, 0.1, 1.7, 0.4),
]
HEAD = "time,hip.x,hip.y,hip.z,head.x,head.y,head.z"


def positions_of(recording):
    return np.concatenate([frames.positions for frames in recording.chunks()])


def times_of(recording):
    return np.concatenate([frames.times for frames in recording.chunks()])


def table(tmp_path, text, name="t.csv", encoding="utf-8"):
    path = tmp_path / name
    path.write_text(text, encoding=encoding)
    return path


def text_of(rows=ROWS, head=HEAD, delimiter=","):
    return "\n".join([head.replace(",", delimiter), *(delimiter.join(map(str, row)) for row in rows)]) + "\n"


EXPECTED = np.array(ROWS)[:, 1:].reshape(3, 2, 3)


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " "])
def test_any_usual_delimiter_is_read(tmp_path, delimiter):
    recording = open_recording(table(tmp_path, text_of(delimiter=delimiter)), ReadOptions(unit="m"))
    np.testing.assert_allclose(positions_of(recording), EXPECTED, rtol=1e-6)
    np.testing.assert_allclose(times_of(recording), [0, 0.02, 0.04])
    assert recording.fps == 50


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_commas_are_read_where_commas_do_not_separate(tmp_path, delimiter):
    head, _, body = text_of(delimiter=delimiter).partition("\n")
    recording = open_recording(table(tmp_path, f"{head}\n{body.replace('.', ',')}"), ReadOptions(unit="m"))
    np.testing.assert_allclose(positions_of(recording), EXPECTED, rtol=1e-6)


@pytest.mark.parametrize(
    "heading",
    [
        "{j}.{a}",
        "{j}_{a}",
        "{j} {a}",
        "{j}:{A}",
        "{j}{A}",
        "{j} ({a})",
        "{j}.position.{a}",
        "{j}_{a} (mm)",
        "{j}_t{a}",
        "{j}.translate{A}",
        "{a}_{j}",
        '"{j}.{a}"',
    ],
)
def test_headings_of_many_spellings_are_understood(heading):
    cells = ["index", *(heading.format(j=j, a=a, A=a.upper()) for j in ("hip", "Left Hand") for a in "xyz")]
    columns = find_columns(cells)
    assert columns.joints == ("hip", "Left Hand")
    assert columns.xyz == ((1, 2, 3), (4, 5, 6))


@pytest.mark.parametrize("begin", [0, 1])
@pytest.mark.parametrize("heading", ["{j}_{k}", "{j}.{k}", "{j}[{k}]", "{j} ({k})"])
def test_axes_may_be_numbers_behind_all_joints(heading, begin):
    joints = ("hip", "C7", "Left Hand")
    cells = ["time", *(heading.format(j=j, k=k + begin) for j in joints for k in range(3))]
    columns = find_columns(cells)
    assert (columns.joints, columns.time) == (joints, 0)
    assert columns.xyz == ((1, 2, 3), (4, 5, 6), (7, 8, 9))


@pytest.mark.parametrize(
    "cells", [["spine_0", "spine_1", "spine_2"], ["a_0", "a_1", "a_2", "b_0", "b_1", "b_2", "c_0", "c_1"]]
)
def test_other_numbers_are_no_axes(cells):
    assert find_columns(["time", *cells]) is None


@pytest.mark.parametrize("heading", ["person_id", "bodyId", "Player", "subject name", "track.id"])
def test_people_who_take_turns_are_performers(tmp_path, heading):
    rows = [(stamp, who, *row) for stamp, *row in ROWS for who in ("b", "", "a/1")]
    text = text_of([*rows, (0.06, "b", *ROWS[0][1:])], HEAD.replace("time", f"time,{heading}"))
    recording = open_recording(table(tmp_path, text), ReadOptions(unit="m"))
    assert (recording.performers, recording.frame_count, recording.fps) == (("b", "a_1"), 7, 50)
    second = open_recording(table(tmp_path, text), ReadOptions(unit="m", performer="a_1"))
    np.testing.assert_allclose(positions_of(second), EXPECTED, rtol=1e-6)
    np.testing.assert_allclose(times_of(second), [0, 0.02, 0.04])


def test_numbers_of_people_become_performers_and_one_person_is_p1(tmp_path):
    rows = [(who, *row) for _, *row in ROWS for who in (72057, 11)]
    head = HEAD.replace("time", "body")
    two = open_recording(table(tmp_path, text_of(rows, head)), ReadOptions(unit="m", fps=10))
    assert two.performers == ("p1", "p2")
    assert [frames.times.tolist() for frames in two.chunks()] == [[0, 0.1, 0.2]] * 2
    one = open_recording(table(tmp_path, text_of(rows[::2], head)))
    assert (one.performers, one.frame_count) == (("p1",), 3)
    crowd = text_of([(who, *ROWS[0][1:]) for who in (*range(100), 0)], head)
    with pytest.raises(FileError, match=r"more than 64 people take turns in it \(column 1\)"):
        open_recording(table(tmp_path, crowd))


@pytest.mark.parametrize(
    ("people", "performers"),
    [
        (("p2", "5"), ("p1", "p2")),
        (("a/b", "a.b"), ("p1", "p2")),
        (("1.0", "0.0"), ("p1", "p2")),
        (("Ann", "7"), ("Ann", "p2")),
    ],
)
def test_no_two_people_get_the_same_name(tmp_path, people, performers):
    text = text_of([(who, *row) for _, *row in ROWS for who in people], HEAD.replace("time", "body"))
    assert open_recording(table(tmp_path, text)).performers == performers


def test_a_running_number_is_nobody(tmp_path):
    head = HEAD.replace("time", "time,track")
    text = text_of([(0.02 * i, i, *ROWS[0][1:]) for i in range(100)], head)
    recording = open_recording(table(tmp_path, text))
    assert (recording.performers, recording.frame_count, recording.fps) == (("p1",), 100, 50)


def test_the_rate_is_that_of_whoever_is_seen_most(tmp_path):
    rows = [(20, "guest", *ROWS[0][1:]), *((20 * i, "host", *ROWS[0][1:]) for i in range(20))]
    recording = open_recording(table(tmp_path, text_of(rows, HEAD.replace("time", "time,person"))))
    assert recording.fps == 50
    assert "times taken as ms" in recording.notes


def test_rotations_and_velocities_are_no_joints():
    cells = [f"hip.{what}.{a}" for what in ("rotation", "vel", "pos") for a in "xyz"]
    assert find_columns(cells).xyz == ((6, 7, 8),)


@pytest.mark.parametrize(
    ("stamps", "heading", "expected"),
    [
        (["0 days 00:00:40.5", "0 days 00:00:40.52", "1 days 00:00:00"], "timestamp", [40.5, 40.52, 86400]),
        (["00:00:01.0", "00:00:01.5", "00:01:02"], "time", [1, 1.5, 62]),
        (["1970-01-01T00:00:01", "1970-01-01 00:00:02.5", "1970-01-01T00:00:03Z"], "time", [1, 2.5, 3]),
        ([1000, 1033, 1066], "timestamp", [1, 1.033, 1.066]),
        ([1000000, 1033000, 1066000], "timestamp", [1, 1.033, 1.066]),
        ([1e18, 1e18 + 33e6, 1e18 + 66e6], "timestamp", [1e9, 1e9 + 0.033, 1e9 + 0.066]),
        ([0, 1, 2], "time_ms", [0, 0.001, 0.002]),
        ([0, 100, 200], "time (s)", [0, 100, 200]),
    ],
)
def test_times_are_read_in_many_ways(tmp_path, stamps, heading, expected):
    rows = [(stamp, *row[1:]) for stamp, row in zip(stamps, ROWS, strict=True)]
    recording = open_recording(table(tmp_path, text_of(rows, HEAD.replace("time", heading))))
    np.testing.assert_allclose(times_of(recording), expected, rtol=1e-12, atol=1e-9)


def test_without_times_the_rate_is_stated_or_assumed_with_a_note(tmp_path):
    rows = [row[1:] for row in ROWS]
    head = HEAD.removeprefix("time,")
    recording = open_recording(table(tmp_path, text_of(rows, head)))
    assert recording.fps == 30
    assert "rate taken as 30 Hz" in recording.notes[0]
    stated = open_recording(table(tmp_path, "# fps=50 unit=cm\n" + text_of(rows, head)))
    assert stated.fps == 50
    assert stated.notes == ()
    np.testing.assert_allclose(positions_of(stated), EXPECTED / 100, rtol=1e-6)


def test_empty_cells_and_words_for_nothing_are_missing(tmp_path):
    text = text_of().replace("0.1,1.7,0.3", ",NaN,0.3").replace("0.1,1.7,0.4", "null,#N/A,-inf")
    positions = positions_of(open_recording(table(tmp_path, text), ReadOptions(unit="m")))
    assert np.isnan(positions[1:, 1]).all()
    assert np.isfinite(positions[:, 0]).all()


def test_confidence_is_read_if_every_joint_has_it(tmp_path):
    head = HEAD + ",hip.confidence,head.confidence"
    rows = [(*row, 1.5, 0.25) for row in ROWS]
    (frames,) = open_recording(table(tmp_path, text_of(rows, head))).chunks()
    np.testing.assert_array_equal(frames.confidence, [[1, 0.25]] * 3)


def test_kinect_tables_are_metres_with_a_hierarchy_and_zeros_are_missing(tmp_path):
    head = "time,SpineBase_x,SpineBase_y,SpineBase_z,SpineMid_x,SpineMid_y,SpineMid_z"
    rows = [ROWS[0], (0.02, 0, 0, 0, 0, 0, 0), ROWS[2]]
    recording = open_recording(table(tmp_path, text_of(rows, head)))
    assert recording.skeleton.parents == (-1, 0)
    assert np.isnan(positions_of(recording)[1]).all()
    centred = [(row[0], 0, 0, 0, *row[4:]) for row in ROWS]
    assert np.isfinite(positions_of(open_recording(table(tmp_path, text_of(centred, head))))).all()


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("0.02,0.1", "0.02,abc", "line 3: 'abc' is not a number"),
        ("0.02,0.1", "soon,0.1", "line 3: 'soon' is no time"),
        ("0.02,0.1,", "0.02,", "line 3: the row has 6 values instead of 7"),
        (HEAD, "a,b,c", "no headings with x, y and z"),
        (HEAD + "\n", "# fps=zero\n" + HEAD + "\n", "fps='zero' is no possible rate"),
        (HEAD + "\n", "# unit=mile\n" + HEAD + "\n", "unit=mile is none of m, cm, mm, inch"),
        (HEAD + "\n", "# parents=1\n" + HEAD + "\n", "parents= does not give one index for each of 2 joints"),
        (HEAD + "\n", "# parents=1,0\n" + HEAD + "\n", "form a cycle"),
        (HEAD + "\n", "# root=tail\n" + HEAD + "\n", "root='tail' is not a joint"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, old, new, problem):
    with pytest.raises(FileError, match=problem):
        list(open_recording(table(tmp_path, text_of().replace(old, new))).chunks())


def test_a_heading_without_rows_has_no_frame(tmp_path):
    with pytest.raises(FileError, match="no whole frame"):
        open_recording(table(tmp_path, HEAD + "\n"))


def test_a_line_of_absurd_length_is_refused_before_it_is_read_whole(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(HEAD + "\n" + "1" * (5 << 20))
    with pytest.raises(FileError, match="line 2: the line has more than"):
        open_recording(path)


def test_names_above_axes_are_joined_with_rate_and_unit_as_optical_systems_write_them(tmp_path):
    text = "Trajectories\n100\n,,LFHD,,,RFHD,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n,,mm,mm,mm,mm,mm,mm\n"
    text += "1,0,100,1000,200,100,1700,200\n2,0,100,1000,300,,,\n"
    recording = open_recording(table(tmp_path, text))
    assert recording.skeleton.names == ("LFHD", "RFHD")
    assert (recording.fps, recording.frame_count, recording.notes) == (100, 2, ())
    np.testing.assert_allclose(positions_of(recording)[0], EXPECTED[0], rtol=1e-6)


def test_numbered_landmarks_get_their_names_and_image_coordinates_a_person_s_size(tmp_path):
    head = "class," + ",".join(f"x{k},y{k},z{k},v{k}" for k in range(1, 34))
    row = "wave," + ",".join(f"0.5,{0.1 + k * 0.02:.2f},0.1,0.9" for k in range(33))
    recording = open_recording(table(tmp_path, f"{head}\n{row}\n{row}\n"))
    assert recording.skeleton.names[:2] == ("nose", "left_eye_inner")
    assert height(positions_of(recording)) == pytest.approx(1.7)
    assert "coordinates have no unit" in "".join(recording.notes)


def test_headings_may_number_the_axes(tmp_path):
    heads = [f"{name}[{axis}]" for name in ("Hips", "C7") for axis in range(4)]
    rows = [[n / 30, 0.1, 1.0, 0.2 + n, 1.0, 0.3, 1.7, 0.4, 1.0] for n in range(5)]
    path = tmp_path / "numbered.csv"
    path.write_text("\n".join(",".join(map(str, row)) for row in [["time", *heads], *rows]))
    recording = open_recording(path, ReadOptions(unit="m"))
    assert recording.skeleton.names == ("Hips", "C7")
    np.testing.assert_allclose(positions_of(recording)[4], [[0.1, 1.0, 4.2], [0.3, 1.7, 0.4]], rtol=1e-6)
