import shutil
import socket
import subprocess
import time

import numpy as np
import pytest
from pythonosc.osc_bundle_builder import OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.osc_lines import log_message


def frames_of(path, **options):
    recording = open_recording(path, ReadOptions(**options))
    return recording, list(recording.chunks())


def positions_of(chunks, performer="p1"):
    return np.concatenate([frames.positions for frames in chunks if frames.performer == performer])


def written(tmp_path, lines, name="a.osc"):
    path = tmp_path / name
    path.write_text("".join(f"{line}\n" for line in lines))
    return path


def bodies(frames=10, joints=("hip", "head"), user=1, stamped=True):
    for i in range(frames):
        stamp = f"eeab8b1e.{i * 2**32 // 30:08x} " if stamped else ""
        for k, joint in enumerate(joints):
            yield f'{stamp}/bodies/{user}/joints/{joint} fffs 0.0 {k + 0.5} {i / 100:.6f} "Tracked"'


@pytest.mark.parametrize(
    ("line", "arguments"),
    [
        ("eeab8b1e.a8922530 /a if 3 1.500000", (3, 1.5)),
        ("/a hd 12345678901 nan", (12345678901, pytest.approx(float("nan"), nan_ok=True))),
        ('/a ss "he said "hi" there" "x y"', None),
        ('/a ss "he said "hi"" "x y"', ('he said "hi"', "x y")),
        ("/a TFNIf #T #F Nil Infinitum -inf", (True, False, None, float("inf"), float("-inf"))),
        ("/a Sci 'word 'c' 7", ("word", "c", 7)),
        ("/a bb [24 byte blob] [0x1 0xff]", (b"?", b"\x01\xff")),
        ("/a m MIDI [0x01 0x02 0x03 0x04]", (b"\1\2\3\4",)),
        ("/a ", ()),
        ("/a f", None),
        ("/a f 1 2", None),
        ("/a i 1.5", None),
        ("/a i " + "9" * 5000, None),
        ("/a z 1", None),
        ("/a b [0x100]", None),
        ("liblo server error 9912 in path /all: Invalid message received", None),
        ("", None),
    ],
)
def test_lines_of_oscdump_are_messages_or_none(line, arguments):
    found = log_message(line)
    assert (found and found.arguments) == arguments


def test_the_time_tag_for_at_once_is_no_time():
    assert log_message("00000000.00000001 /a ").time is None
    assert log_message("83aa7e80.40000000 /a ").time == 2208988800.25


@pytest.mark.skipif(shutil.which("oscdump") is None, reason="oscdump (liblo-tools) is not installed")
def test_what_oscdump_writes_of_messages_and_bundles_reads(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    path = tmp_path / "real.osc"
    with path.open("wb") as log:
        dump = subprocess.Popen(["oscdump", "-L", str(port)], stdout=log)
    try:
        send_until_heard(port, path)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            for i in range(30):
                bundle = OscBundleBuilder(time.time())
                for joint, y in (("hip", 1.0), ("head", 1.7)):
                    bundle.add_content(kinect(joint, y, i / 100))
                out.sendto(bundle.build().dgram, ("127.0.0.1", port))
                time.sleep(0.01)
        wait_for(lambda: path.read_text().count("/head ") == 30)
    finally:
        dump.terminate()
        dump.wait(5)
    recording, chunks = frames_of(path)
    assert recording.frame_count == 30
    np.testing.assert_allclose(positions_of(chunks)[:, 1, 1], 1.7, atol=1e-5)
    np.testing.assert_allclose(positions_of(chunks)[:, 0, 2], np.arange(30) / 100, atol=1e-5)
    assert 0.28 < chunks[-1].times[-1] - chunks[0].times[0] < 3


def kinect(joint, y, z):
    message = OscMessageBuilder(f"/bodies/1/joints/{joint}")
    for value in (0.0, y, z, "Tracked"):
        message.add_arg(value)
    return message.build()


def send_until_heard(port, path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        wait_for(lambda: out.sendto(b"/ping\0\0\0,\0\0\0", ("127.0.0.1", port)) and path.stat().st_size > 0)


def wait_for(condition, seconds=10):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_several_bodies_are_performers(tmp_path):
    lines = [line for pair in zip(bodies(), bodies(user=72057594037927936), strict=True) for line in pair]
    recording, chunks = frames_of(written(tmp_path, lines))
    assert recording.performers == ("p1", "p72057594037927936")
    assert recording.frame_count == 20
    assert len(positions_of(chunks, "p72057594037927936")) == 10
    only, chunks = frames_of(tmp_path / "a.osc", performer="p1")
    assert only.performers == ("p1",)
    assert sum(len(frames) for frames in chunks) == 10


def test_joints_that_turn_up_later_are_missing_before(tmp_path):
    lines = [*bodies(3), *(line.replace("1e.", "20.") for line in bodies(7, ("hip", "head", "hand")))]
    recording, chunks = frames_of(written(tmp_path, lines))
    assert recording.skeleton.names == ("hip", "head", "hand")
    missing = np.isnan(positions_of(chunks)[:, 2, 0])
    assert missing[:3].all()
    assert not missing[-6:].any()


def test_a_log_without_times_is_counted_and_says_so(tmp_path):
    recording, chunks = frames_of(written(tmp_path, bodies(stamped=False)))
    assert recording.fps == 60
    assert any("no times" in note for note in recording.notes)
    np.testing.assert_allclose(np.concatenate([frames.times for frames in chunks]), np.arange(10) / 60)


def test_lines_that_are_no_messages_are_counted(tmp_path):
    lines = [*bodies(5), "liblo server error 9912", *list(bodies(9))[10:], "/bodies/1/joints/hip f"]
    recording, chunks = frames_of(written(tmp_path, lines))
    assert len(positions_of(chunks)) == 9
    assert "2 lines are no messages" in recording.notes


def test_a_log_is_known_by_its_content_in_a_text_file(tmp_path):
    assert frames_of(written(tmp_path, bodies(), "notes.txt"))[0].frame_count == 10


@pytest.mark.parametrize(
    ("lines", "why"),
    [
        (["eeab8b1e.00000000 /tempo f 120.0"] * 3, "none of 3 messages is of a known profile.*'/tempo'"),
        (['/mossar/frame sidb "p1" 0 0.0 [456 byte blob]'] * 3, "oscdump leaves out the content of blobs"),
        (["/joint si 1 2"] * 3, "this does not look like"),
        (["/joint ss hip"] * 3, "this does not look like"),
    ],
)
def test_a_log_without_a_frame_is_one_clear_line(tmp_path, lines, why):
    with pytest.raises(FileError, match=why):
        frames_of(written(tmp_path, lines))
