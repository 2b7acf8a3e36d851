import struct

import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_recording


def positions_of(recording):
    return np.concatenate([frames.positions for frames in recording.chunks()])


@pytest.mark.parametrize("machine", [84, 85, 86])
@pytest.mark.parametrize("integer", [False, True])
def test_all_byte_orders_and_kinds_of_numbers_agree(sample, machine, integer):
    expected = positions_of(open_recording(sample("c3d")))
    found = open_recording(sample("c3d", machine=machine, integer=integer))
    np.testing.assert_allclose(positions_of(found), expected, atol=1e-4)
    assert (found.fps, found.skeleton.names) == (60, ("hip", "knee", "foot", "head"))


def test_a_negative_residual_is_a_gap(sample):
    positions = positions_of(open_recording(sample("c3d")))
    assert np.isnan(positions[0, 1]).all()
    assert np.isnan(positions).sum() == 3


def test_a_trimmed_recording_keeps_its_frame_numbers_and_times(sample):
    frames = next(open_recording(sample("c3d", first=50)).chunks())
    assert frames.first_frame == 49
    assert frames.times[0] == pytest.approx(49 / 60)
    whole = next(open_recording(sample("c3d")).chunks())
    assert whole.first_frame is None
    assert whole.times[0] == 0


def test_unnamed_points_are_left_out_if_others_have_names(sample):
    recording = open_recording(sample("c3d", labels=("hip", "*12", "foot", "head")))
    assert recording.skeleton.names == ("hip", "foot", "head")
    assert open_recording(sample("c3d", labels=("*1", "*2"))).skeleton.names == ("point0", "point1")


def test_a_subject_in_front_of_the_labels_is_taken_off(sample):
    labels = tuple(f"anna:{name}" for name in ("hip", "knee", "foot", "head"))
    recording = open_recording(sample("c3d", labels=labels))
    assert recording.skeleton.names == ("hip", "knee", "foot", "head")
    assert recording.performers == ("p1",)


def test_subjects_with_the_same_markers_are_performers_and_props_are_left_out(sample):
    labels = ("anna:hip", "anna:head", "bo:head", "bo:hip", "ball:a")
    recording = open_recording(sample("c3d", labels=labels))
    assert recording.performers == ("anna", "bo")
    assert recording.notes == ("markers left out: ball (1)",)
    anna, bo = recording.chunks()
    everything = positions_of(open_recording(sample("c3d", labels=tuple("abcde"))))
    np.testing.assert_array_equal(anna.positions, everything[:, [0, 1]])
    np.testing.assert_array_equal(bo.positions, everything[:, [3, 2]])
    only = open_recording(sample("c3d", labels=labels), ReadOptions(performer="ball"))
    assert only.skeleton.names == ("a",)


def test_markers_without_known_joints_have_the_centroid_as_centre(sample):
    recording = open_recording(sample("c3d", labels=("LFHD", "RFHD")))
    assert recording.skeleton.root == -1
    assert recording.skeleton.parents == (-1, -1)


@pytest.mark.parametrize("at", [2, 8, 16, 18, 22])
def test_absurd_counts_in_the_header_are_refused_or_cut_to_the_file(sample, at):
    path = sample("c3d")
    data = bytearray(path.read_bytes())
    data[at : at + 2] = b"\xff\xff"
    path.write_bytes(data)
    found = read_or_refused(path)
    assert found is None or len(found) <= 30


HEADER = {
    "analogue values alone": (2, "2H", (0, 64)),
    "no frames": (8, "H", (0,)),
    "frames that end before they begin": (6, "2H", (50, 10)),
    "as many points and values as can be said": (2, "2H", (65535, 65535)),
    "data in the header": (16, "H", (1,)),
    "data beyond the end": (16, "H", (65535,)),
    "data among the parameters": (16, "H", (2,)),
    "parameters nowhere": (0, "B", (0,)),
    "parameters beyond the end": (0, "B", (255,)),
    "another machine": (515, "B", (0,)),
    "a group that leads back to itself": (523, "h", (-7,)),
    "a group that leads nowhere": (523, "h", (32767,)),
    **{f"scale {scale}": (12, "f", (scale,)) for scale in (0.0, 1e38, 1e-45, np.inf, np.nan)},
    **{f"rate {rate}": (20, "f", (rate,)) for rate in (0.0, -1.0, 1e38, np.inf, np.nan)},
}


@pytest.mark.parametrize("machine", [84, 85, 86])
@pytest.mark.parametrize("integer", [False, True])
@pytest.mark.parametrize("name", HEADER)
def test_impossible_headers_are_refused_or_read_without_infinities(sample, machine, integer, name):
    at, kind, values = HEADER[name]
    path = sample("c3d", machine=machine, integer=integer)
    data = bytearray(path.read_bytes())
    struct.pack_into(f"{'>' if machine == 86 else '<'}{kind}", data, at, *values)
    path.write_bytes(data)
    found = read_or_refused(path)
    assert found is None or (len(found) <= 30 and not np.isinf(found).any())


@pytest.mark.parametrize("machine", [84, 85, 86])
@pytest.mark.parametrize("integer", [False, True])
@pytest.mark.parametrize("bits", [b"\0\0\0\0", b"\xff\xff\xff\xff", b"\xff\x7f\xff\xff", b"\x80\xc0\0\0"])
def test_data_of_any_bits_are_numbers_or_missing(sample, machine, integer, bits):
    path = sample("c3d", machine=machine, integer=integer)
    data = path.read_bytes()
    path.write_bytes(data[:1536] + bits * ((len(data) - 1536) // 4))
    found = positions_of(open_recording(path))
    assert len(found) == 30
    assert not np.isinf(found).any()


@pytest.mark.parametrize("machine", [84, 85, 86])
def test_files_that_are_cut_off_anywhere_are_refused_or_read_up_to_there(sample, machine):
    path = sample("c3d", machine=machine)
    whole = path.read_bytes()
    frame = (len(whole) - 1536) // 30
    for length in (0, 1, 2, 20, 511, 513, 600, 1023, 1535, 1536, 1537, 1536 + frame - 1):
        path.write_bytes(whole[:length])
        assert read_or_refused(path) is None
    for frames in (1, 29):
        path.write_bytes(whole[: 1536 + frames * frame + 3])
        assert len(read_or_refused(path)) == frames


def with_counts(path, body, last, **parameters):
    """Replace the data, and say in the header and in parameters how many frames there are."""
    header, section = bytearray(path.read_bytes()[:512]), path.read_bytes()[512:1536].rstrip(b"\0") + b"\0"
    header[8:10] = struct.pack("<H", last)
    for name, value in parameters.items():
        kind, number = value
        body_of = bytes([4 if kind == "f" else 2, 0]) + struct.pack(f"<{kind}", number) + b"\0"
        section += bytes([len(name), 1]) + name.encode() + struct.pack("<h", len(body_of) + 2) + body_of
    path.write_bytes(bytes(header) + section.ljust(1024, b"\0") + body)
    return path


@pytest.mark.parametrize(
    ("last", "parameters"),
    [
        (65535, {"FRAMES": ("f", 70000)}),
        (65535, {"FRAMES": ("h", -1), "LONG_FRAMES": ("f", 70000)}),
        (65535, {"FRAMES": ("h", -1)}),
        (65535, {}),
        (70000 - 65536, {"FRAMES": ("f", 70000)}),
        (70000 - 65536, {}),
    ],
)
def test_recordings_longer_than_the_header_can_say_are_read_to_their_end(sample, last, parameters):
    body = np.tile(np.array([1, 2, 3, 0], "<f4"), 140000).tobytes() + bytes(512)
    path = with_counts(sample("c3d", labels=("a", "b")), body, last, **parameters)
    recording = open_recording(path, ReadOptions(unit="m"))
    assert (recording.frame_count, recording.notes) == (70000, ())
    assert np.isfinite(positions_of(recording)).all()


def test_a_header_that_tells_of_the_whole_take_does_not_make_its_part_cut_off(sample):
    body = np.ones((20, 8), "<f4").tobytes()
    path = with_counts(sample("c3d", labels=("a", "b")), body, 900, FRAMES=("h", 20))
    assert open_recording(path).frame_count == 20
    assert not any("cut off" in note for note in open_recording(path).notes)


def test_the_place_of_the_data_may_stand_in_the_parameters_only(sample):
    path = with_counts(
        sample("c3d", labels=("a", "b")), np.ones((20, 8), "<f4").tobytes(), 20, DATA_START=("h", 4)
    )
    data = bytearray(path.read_bytes())
    data[16:18] = b"\0\0"
    path.write_bytes(data)
    assert open_recording(path).frame_count == 20


@pytest.mark.parametrize(
    ("unit", "factor"), [("Metres", 1000), ("centimeters", 10), ("INCHES", 25.4), ("ft", 304.8)]
)
def test_units_are_those_of_the_file_however_it_calls_them(sample, unit, factor):
    expected = positions_of(open_recording(sample("c3d"))) * factor
    recording = open_recording(sample("c3d", unit=unit))
    assert recording.notes == ()
    np.testing.assert_allclose(positions_of(recording), expected, rtol=1e-5)


def read_or_refused(path):
    try:
        return positions_of(open_recording(path))
    except FileError:
        return None


def test_the_six_twins_agree(shared):
    twins = [p for p in (shared / "formats" / "c3d").iterdir() if p.stem[-4:].lower() in {"_int", "real"}]
    assert len(twins) == 6
    found = [open_recording(path) for path in twins]
    for recording in found:
        assert recording.fps == 50
        assert recording.skeleton == found[0].skeleton
        # The integers' step.
        np.testing.assert_allclose(positions_of(recording), positions_of(found[0]), atol=3e-4)


def test_markers_agree_with_ezc3d(shared):
    import ezc3d

    for name in ("02_01.c3d", "pc_real.c3d", "Dec_real.c3d", "DEC_INT.C3D", "pc_int.c3d"):
        path = shared / "formats" / "c3d" / name
        expected = ezc3d.c3d(str(path))["data"]["points"][:3].transpose(2, 1, 0) / 1000
        np.testing.assert_allclose(positions_of(open_recording(path)), expected, atol=1e-5)


def test_real_files_that_libraries_refuse_are_read(shared):
    folder = shared / "formats" / "c3d"
    swing = open_recording(folder / "golfswing.c3d")
    assert (swing.frame_count, len(swing.skeleton)) == (514, 29)
    odd = open_recording(folder / "badParameterOffset.c3d")
    assert (odd.fps, odd.frame_count, len(odd.skeleton)) == (250, 111, 41)
    clinical = open_recording(folder / "PiG_Calibration-FlatFoot-One.c3d")
    assert "LHipAngles" not in clinical.skeleton.names
    trimmed = next(open_recording(folder / "02_01.c3d").chunks())
    assert trimmed.first_frame == 49
    with pytest.raises(FileError, match="the file is empty"):
        open_recording(folder / "Empty.c3d")


def test_points_without_a_name_are_left_out_with_a_note(sample):
    labels = ("LASI", "*0", "*1", "RASI")
    recording = open_recording(sample("c3d", labels=labels))
    assert recording.skeleton.names == ("LASI", "RASI")
    assert "2 points without a name (*0, *1) left out" in recording.notes
    assert open_recording(sample("c3d", labels=("*0", "*1"))).notes == ()
