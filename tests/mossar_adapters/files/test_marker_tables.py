import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.units import height


def positions_of(recording):
    return np.concatenate([frames.positions for frames in recording.chunks()])


def rewritten(path, old, new):
    text = path.read_bytes().decode("utf-8")
    assert old in text
    path.write_bytes(text.replace(old, new).encode())
    return path


@pytest.mark.parametrize("kind", ["trc", "motive", "qtm"])
def test_the_three_agree(sample, kind):
    expected = positions_of(open_recording(sample("csv")))
    np.testing.assert_allclose(positions_of(open_recording(sample(kind))), expected, atol=2e-5)


@pytest.mark.parametrize("delimiter", [",", ";"])
def test_trc_may_be_separated_by_commas_or_semicolons(sample, delimiter):
    path = sample("trc")
    expected = positions_of(open_recording(path))
    np.testing.assert_array_equal(positions_of(open_recording(rewritten(path, "\t", delimiter))), expected)


def test_the_blank_row_above_the_rows_of_a_trc_is_none_though_it_has_delimiters(sample):
    path = sample("trc")
    expected = positions_of(open_recording(path))
    path = rewritten(rewritten(path, "\n\n", "\n" + "\t" * 13 + "\n"), "\t", ",")
    np.testing.assert_array_equal(positions_of(open_recording(path)), expected)


def test_motive_saved_again_by_a_spreadsheet_reads_the_same(sample):
    path = sample("motive")
    expected = positions_of(open_recording(path))
    for old, new in ((",", ";"), (".", ",")):
        rewritten(path, old, new)
    np.testing.assert_array_equal(positions_of(open_recording(path)), expected)


def test_trc_blanks_are_missing_and_trailing_blanks_may_be_left_out(sample):
    path = sample("trc")
    lines = path.read_text().splitlines()
    cells = lines[8].split("\t")
    cells[2:5] = ["", "", ""]
    lines[8] = "\t".join(cells[:-3])
    path.write_text("\n".join(lines) + "\n")
    positions = positions_of(open_recording(path))
    missing = np.isnan(positions).all(axis=2)
    assert np.argwhere(missing).tolist() == [[2, 0], [2, 3]]


@pytest.mark.parametrize(("unit", "factor"), [("m", 1000), ("cm", 10), ("inch", 25.4)])
def test_trc_units_are_those_of_the_file(sample, unit, factor):
    expected = positions_of(open_recording(sample("trc"))) * factor
    found = positions_of(open_recording(rewritten(sample("trc"), "\tmm\t", f"\t{unit}\t")))
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_a_trc_that_was_trimmed_keeps_its_frame_numbers(sample):
    path = rewritten(sample("trc"), "\n1\t0.00000\t", "\n101\t1.66667\t")
    frames = next(open_recording(path).chunks())
    assert frames.first_frame == 100
    assert next(open_recording(sample("trc")).chunks()).first_frame is None


def test_a_marker_of_a_trc_without_a_name_is_left_out_and_moves_no_other(sample):
    expected = positions_of(open_recording(sample("trc")))
    recording = open_recording(rewritten(sample("trc"), "\tknee\t", "\t\t"))
    assert recording.skeleton.names == ("hip", "foot", "head")
    np.testing.assert_array_equal(positions_of(recording), expected[:, [0, 2, 3]])


def test_names_of_a_trc_may_stand_in_a_row_or_in_quotes(sample):
    expected = positions_of(open_recording(sample("trc")))
    for names in ("hip\tknee\tfoot\thead", '"hip"\t\t\t"knee"\t\t\t"foot"\t\t\t"head"'):
        recording = open_recording(rewritten(sample("trc"), "hip\t\t\tknee\t\t\tfoot\t\t\thead", names))
        assert recording.skeleton.names == ("hip", "knee", "foot", "head")
        np.testing.assert_array_equal(positions_of(recording), expected)


def test_facts_of_a_trc_may_have_decimal_commas(sample):
    recording = open_recording(rewritten(sample("trc"), "\n60\t60\t", "\n60,00\t60,00\t"))
    assert (recording.fps, recording.frame_count, recording.notes) == (60, 30, ())


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("Frame#", "What", "there is no line of marker names"),
        ("hip\t\t\tknee\t\t\tfoot\t\t\thead", "", "there are no marker names"),
        ("\n7\t0.1", "\n7\tnoon0.1", "line 13: .* is not a number"),
    ],
)
def test_what_is_wrong_with_a_trc_is_said(sample, old, new, problem):
    with pytest.raises(FileError, match=problem):
        list(open_recording(rewritten(sample("trc"), old, new)).chunks())


def test_motive_has_bones_parents_and_the_hip_as_root(sample):
    recording = open_recording(sample("motive"))
    assert recording.skeleton.names == ("Hip", "Thigh", "Foot", "Head")
    assert recording.skeleton.parents == (-1, 0, 1, 0)
    assert recording.skeleton.root == 0


def test_motive_without_a_parent_line_and_with_millimetres(sample):
    path = sample("motive")
    text = path.read_bytes().decode("utf-8").replace("Length Units,Meters", "Length Units,Millimeters")
    path.write_text("\n".join(line for line in text.split("\r\n") if not line.startswith(",Parent")))
    recording = open_recording(path, ReadOptions())
    assert np.nanmax(positions_of(recording)) < 0.01
    assert recording.frame_count == 30


def test_motive_takes_markers_where_there_are_no_bones(sample):
    path = rewritten(sample("motive"), "Bone", "Marker")
    assert open_recording(rewritten(path, "anna:Foot", "Unlabeled 12")).skeleton.names == (
        "Hip",
        "Thigh",
        "Head",
    )


def test_motive_takes_unlabeled_markers_where_there_is_nothing_else(sample):
    path = rewritten(sample("motive"), "Bone", "Marker")
    for i, name in enumerate(("anna", "Thigh", "Foot", "Head")):
        rewritten(path, f"anna:{name}", f"Unlabeled {i}")
    assert len(open_recording(path).skeleton) == 4


def test_motive_takes_may_have_commas_in_their_names(sample):
    path = rewritten(sample("motive"), "Take Name,t,", "Take Name,walk, then run,")
    recording = open_recording(rewritten(path, "Meters", "Millimeters"))
    assert recording.notes == ()
    assert height(positions_of(recording)) < 0.01


def test_motive_bones_relative_to_their_parents_are_refused_but_not_markers(sample):
    path = rewritten(sample("motive"), "Length Units,Meters", "Length Units,Meters,Coordinate Space,Local")
    with pytest.raises(FileError, match="export them in global coordinates"):
        open_recording(path)
    assert open_recording(rewritten(path, "Bone", "Marker")).frame_count == 30


def test_qtm_frames_without_any_marker_are_missing_frames(sample):
    path = sample("qtm")
    lines = path.read_text().splitlines()
    for k in (6, 7, 20):
        lines[k] = "\t" * 11
    path.write_text("\n".join(lines) + "\n")
    recording = open_recording(path)
    assert (recording.frame_count, recording.notes) == (30, ())
    assert np.argwhere(np.isnan(positions_of(recording)).all(axis=(1, 2))).ravel().tolist() == [0, 1, 14]


@pytest.mark.parametrize("tabs", ["\t\t\t", ""])
def test_qtm_knows_its_frame_and_time_columns_though_the_last_marker_is_missing_at_first(sample, tabs):
    path = sample("qtm")
    lines = path.read_text().splitlines()
    expected = positions_of(open_recording(path))
    rows = [f"{i + 1}\t{i / 60:.5f}\t{row}" for i, row in enumerate(lines[6:])]
    rows[0] = "\t".join(rows[0].split("\t")[:-3]) + tabs
    path.write_text("\n".join([*lines[:6], "Frame\tTime\thip X\thip Y\thip Z", *rows]) + "\n")
    found = positions_of(open_recording(path))
    assert np.isnan(found[0, 3]).all()
    np.testing.assert_array_equal(found[1:], expected[1:])
    np.testing.assert_array_equal(found[0, :3], expected[0, :3])


def test_qtm_without_a_rate_asks_for_one(sample):
    path = rewritten(sample("qtm"), "FREQUENCY\t60\n", "")
    with pytest.raises(FileError, match="states neither rate nor times; set --fps"):
        open_recording(path)
    assert open_recording(path, ReadOptions(fps=50)).fps == 50


@pytest.mark.parametrize("headed_columns", [True, False])
def test_qtm_with_frame_and_time_columns(sample, headed_columns):
    path = sample("qtm")
    lines = path.read_text().splitlines()
    headed = lines[:6]
    headed += ["Frame\tTime\t" + "\t".join(f"m{k}" for k in range(12))] * headed_columns
    headed += [f"{i + 1}\t{i / 60:.5f}\t{row}" for i, row in enumerate(lines[6:])]
    expected = positions_of(open_recording(path))
    path.write_text("\n".join(headed) + "\n")
    recording = open_recording(path)
    np.testing.assert_array_equal(positions_of(recording), expected)
    assert recording.fps == 60


def test_qtm_of_bodies_is_refused(sample):
    with pytest.raises(FileError, match="holds '6D' data; only 3D markers"):
        open_recording(rewritten(sample("qtm"), "DATA_INCLUDED\t3D", "DATA_INCLUDED\t6D"))


@pytest.mark.parametrize(
    ("kind", "old", "new"),
    [
        ("trc", "hip\t\t\t", "hip\t\t\t" + "x\t\t\t" * 7000),
        ("qtm", "MARKER_NAMES\t", "MARKER_NAMES\t" + "x\t" * 7000),
    ],
)
def test_headings_that_ask_for_too_many_columns_take_no_memory(sample, kind, old, new):
    with pytest.raises(FileError, match=r"columns; at most 20000 can be read"):
        open_recording(rewritten(sample(kind), old, new))


def test_msrc12_rows_without_a_player_are_missing(sample):
    recording = open_recording(sample("msrc12"))
    positions = positions_of(recording)
    assert np.isnan(positions[0]).all()
    assert np.isfinite(positions[1:]).all()
    assert recording.skeleton.names[recording.skeleton.root] == "HipCenter"


def test_msrc12_may_have_commas(sample):
    expected = positions_of(open_recording(sample("msrc12")))
    found = positions_of(open_recording(rewritten(sample("msrc12"), " ", ",")))
    np.testing.assert_array_equal(found, expected)


def test_ntu_states_are_confidence(sample):
    (frames,) = open_recording(sample("ntu")).chunks()
    assert frames.confidence[0, :5].tolist() == [1, 1, 1, 0.5, 1]


def test_ntu_bodies_are_performers_with_their_frames(tmp_path):
    joint = "1.0 2.0 3.0 0 0 0 0 0 0 0 1 {}"

    def body(number, state=2):
        return [f"{number} 0 0 0 0 0 0 0 0 2", "25", *([joint.format(state)] * 25)]

    frames = [["1", *body(7)], ["2", *body(7), *body(9, 0)], ["0"], ["1", *body(9)]]
    (tmp_path / "a.skeleton").write_text(
        "\n".join(["4", *(line for frame in frames for line in frame)]) + "\n"
    )
    recording = open_recording(tmp_path / "a.skeleton")
    assert recording.performers == ("p1", "p2")
    found = [(f.performer, f.first_frame, f.times.tolist()) for f in recording.chunks()]
    assert sorted(found) == [("p1", 0, [0, 1 / 30]), ("p2", 1, [1 / 30]), ("p2", 3, [0.1])]
    second = next(f for f in recording.chunks() if f.performer == "p2")
    assert np.isnan(second.positions).all()
    assert open_recording(tmp_path / "a.skeleton", ReadOptions(performer="p2")).performers == ("p2",)


def test_absurd_counts_of_ntu_are_refused(tmp_path):
    for text, problem in (("1\n99\n", "'99' is not a count"), ("1\n1\nx\n26\n", "26 joints instead of 25")):
        (tmp_path / "a.skeleton").write_text(text)
        with pytest.raises(FileError, match=problem):
            open_recording(tmp_path / "a.skeleton")


@pytest.mark.parametrize(
    ("name", "fps", "shape", "tall"),
    [
        ("trc/subject01_walk1.trc", 60, (151, 41), 1.73),
        ("csv/optitrack_motive.csv", 120, (32, 51), 1.5),
        ("csv/kinect-skeleton_0.csv", 11.5, (1099, 25), 1.03),
        ("msrc12/P1_1_1_p06.csv", 30.16, (1027, 20), 1.6),
    ],
)
def test_real_files_have_the_rate_count_and_height_that_they_state(shared, name, fps, shape, tall):
    recording = open_recording(shared / "formats" / name)
    positions = positions_of(recording)
    assert positions.shape == (*shape, 3)
    assert recording.fps == pytest.approx(fps, rel=1e-3)
    assert height(positions) == pytest.approx(tall, abs=0.02)


def test_a_real_file_that_is_cut_off_yields_its_whole_frames_with_a_note(shared):
    recording = open_recording(shared / "formats" / "trc" / "markers.trc")
    assert len(positions_of(recording)) == recording.frame_count >= 93
    assert recording.notes[0] == f"the file is cut off: {recording.frame_count} of 652 frames are there"


def test_times_count_where_the_stated_rate_contradicts_them(sample):
    plain = open_recording(sample("trc"))
    path = sample("trc")
    lines = path.read_text().split("\n")
    lines[2] = "\t".join([f"{plain.fps / 2:.2f}", *lines[2].split("\t")[1:]])
    path.write_text("\n".join(lines))
    recording = open_recording(path)
    assert recording.fps == plain.fps
    assert any("the times count; set --fps" in note for note in recording.notes)
    assert plain.notes == ()
    assert open_recording(path, ReadOptions(fps=25)).fps == 25


def trc_with_times(path, rate, time):
    """Write a TRC that says a rate, Hz, and has `time(k)` in row k."""
    head = ["PathFileType\t4\t(X/Y/Z)\ta.trc", "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits"]
    head += [
        f"{rate}\t{rate}\t40\t2\tm",
        "Frame#\tTime\tC7\t\t\tHips",
        "\t\tX1\tY1\tZ1\tX2\tY2\tZ2",
        "",
    ]
    rows = [f"{k + 1}\t{time(k)}\t0\t1.6\t0.{k:02}\t0\t1\t0" for k in range(40)]
    path.write_text("\n".join([*head, *rows, ""]))
    return open_recording(path)


@pytest.mark.parametrize(
    ("time", "why"), [(lambda k: f"{k}", "frame numbers"), (lambda k: f"{k * 20.0:.1f}", "step by 20 s")]
)
def test_the_stated_rate_counts_where_no_frames_have_such_times(tmp_path, time, why):
    recording = trc_with_times(tmp_path / "a.trc", 50, time)
    assert recording.fps == 50
    assert np.diff([t for frames in recording.chunks() for t in frames.times]) == pytest.approx(1 / 50)
    assert [note for note in recording.notes if why in note and "the heading counts; set --fps" in note]


def test_times_that_are_rounded_do_not_contradict_the_stated_rate(tmp_path):
    recording = trc_with_times(tmp_path / "a.trc", 60, lambda k: f"{k / 60:.2f}")
    assert recording.fps == 60
    assert not [note for note in recording.notes if "heading" in note]
