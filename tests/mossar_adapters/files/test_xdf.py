import numpy as np
import pytest

from mossar_adapters.files import FileError, open_recording


def rewritten(path, old, new):
    data = path.read_bytes()
    assert old in data
    assert len(old) == len(new)
    path.write_bytes(data.replace(old, new))
    return path


def test_times_joints_and_metres_are_those_of_the_stream(sample):
    recording = open_recording(sample("xdf"))
    (frames,) = recording.chunks()
    assert recording.skeleton.names == ("hip", "knee", "foot", "head")
    np.testing.assert_allclose(frames.times, 5 + np.arange(30) / 60, atol=1e-6)


def test_a_recording_without_motion_capture_names_its_streams(sample):
    with pytest.raises(FileError, match=r"no stream of type MoCap; streams: Body \(Audio\)"):
        open_recording(rewritten(sample("xdf"), b"MoCap", b"Audio"))


def test_a_count_that_does_not_fit_its_chunk_takes_no_memory(sample):
    path = sample("xdf")
    count = b"\x04" + (10).to_bytes(4, "little") + b"\x08"
    with pytest.raises(FileError, match="the count of 4294967295 samples does not fit a chunk of"):
        open_recording(rewritten(path, count, b"\x04\xff\xff\xff\xff\x08"))


def test_declarations_in_a_header_are_refused(sample):
    with pytest.raises(FileError, match="declarations"):
        open_recording(rewritten(sample("xdf"), b"<name>Body</name>", b"<!ENTITY x 'yyy'>"))
