"""Videos as recordings: estimated once, kept beside the file, with their own times; and what is no video."""

import shutil
import subprocess

import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.loaded import load
from mossar_adapters.joint_sets import BLAZEPOSE_33
from mossar_adapters.pose.pictures import describe, pictures
from mossar_adapters.pose.types import SKELETON

needs_weights = pytest.mark.usefixtures("weights")
needs_ffmpeg = pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not here")


@needs_weights
def test_a_video_is_a_recording(film, pan):
    recording = open_recording(film(pan))
    take = load(recording)
    assert take.skeleton.names == BLAZEPOSE_33.names
    assert take.positions.shape == (60, 33, 3)
    assert np.allclose(take.times, np.arange(60) / 30, atol=1e-3)
    assert recording.fps == pytest.approx(30.0)
    assert "a person in 60 of 60 pictures" in recording.notes


@needs_weights
def test_the_estimate_is_kept_beside_the_video_and_is_a_recording_of_its_own(film, pan):
    path = film(pan)
    first = load(open_recording(path))
    archive = path.with_name("film.mp4.pose.npz")
    with np.load(archive) as arrays:
        assert arrays["positions"].shape == (60, 33, 3)
        assert arrays["confidence"].shape == (60, 33)
        assert arrays["joint_names"].tolist() == list(BLAZEPOSE_33.names)
        assert arrays["parents"].tolist() == list(BLAZEPOSE_33.parents)
        assert arrays["times"].shape == (60,)
    again = load(open_recording(archive))
    assert np.array_equal(first.positions, again.positions, equal_nan=True)
    assert np.array_equal(first.times, again.times)
    assert first.skeleton == again.skeleton == SKELETON  # that of cameras: the same body centre


@needs_weights
def test_a_video_is_estimated_once_unless_it_changed_or_is_to_be_estimated_again(film, pan):
    path = film(pan)
    open_recording(path)
    archive = path.with_name("film.mp4.pose.npz")
    made = archive.stat().st_mtime_ns
    assert open_recording(path).notes == ()
    assert archive.stat().st_mtime_ns == made
    open_recording(path, ReadOptions(again=True))
    assert archive.stat().st_mtime_ns > made
    film(pan[:30])
    assert open_recording(path).frame_count == 30


@needs_weights
def test_confidence_is_read_from_the_archive(film, pan):
    recording = open_recording(film(pan[:10]))
    frames = next(iter(recording.chunks()))
    assert frames.confidence.shape == (10, 33)
    assert frames.confidence[:, BLAZEPOSE_33.index("nose")].min() > 0.9


@needs_weights
def test_pictures_without_a_person_are_left_out(film, pan):
    empty = np.zeros_like(pan[0])
    take = load(open_recording(film([*pan[:10], *[empty] * 10, *pan[:10]])))
    assert 18 <= len(take.times) <= 21  # of a coded picture something of the one before may be left
    assert np.diff(take.times).max() > 0.3


@needs_weights
def test_a_video_without_anybody_is_refused(film, pan):
    with pytest.raises(FileError, match="no person was found in its 20 pictures"):
        open_recording(film([np.zeros_like(pan[0])] * 20))


@needs_weights
@pytest.mark.parametrize("name", ["film.avi", "film.mov", "film.mkv", "film.webm"])
def test_other_containers_are_read(film, pan, name):
    assert load(open_recording(film(pan[:20], name))).positions.shape == (20, 33, 3)


@needs_weights
def test_a_cut_to_another_place_is_survived(film, pan):
    beside = [np.ascontiguousarray(np.roll(picture, 200, axis=1)) for picture in pan[:20]]
    take = load(open_recording(film([*pan[:20], *beside])))
    assert len(take.times) >= 38


def test_a_text_file_called_mp4_is_refused(tmp_path):
    path = tmp_path / "notes.mp4"
    path.write_text("this is no film")
    with pytest.raises(FileError, match="does not look like video"):
        open_recording(path)


def test_an_empty_file_is_refused(tmp_path):
    path = tmp_path / "film.mp4"
    path.touch()
    with pytest.raises(FileError, match="the file is empty"):
        open_recording(path)


@needs_weights
def test_a_video_without_its_index_is_refused(film, pan):
    path = film(pan)
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(FileError, match="cannot be opened as a video") as error:
        open_recording(path)
    assert "\n" not in str(error.value)


@needs_weights
def test_a_video_that_was_cut_off_is_read_as_far_as_it_goes(film, pan):
    path = film(pan, "film.avi")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    recording = open_recording(path)
    assert 10 < recording.frame_count < 40


@needs_weights
def test_a_video_in_a_folder_that_cannot_be_written_to_is_read(film, pan, read_only_disk):
    path = film(pan[:10])
    subprocess.run(["mount", "-o", "remount,rw", str(read_only_disk)], check=True)
    shutil.copy(path, read_only_disk / "film.mp4")
    subprocess.run(["mount", "-o", "remount,ro", str(read_only_disk)], check=True)
    recording = open_recording(read_only_disk / "film.mp4")
    assert load(recording).positions.shape == (10, 33, 3)
    assert recording.skeleton == SKELETON
    assert any("nothing is kept" in note for note in recording.notes)


@needs_weights
@pytest.mark.parametrize(("size", "fps"), [((2160, 3840), 30.0), ((640, 360), 30.0), ((360, 480), 240.0)])
def test_4k_portrait_and_240_hz_are_read(film, astronaut, size, fps):
    import cv2

    side = min(size)
    picture = np.zeros((*size, 3), np.uint8)
    picture[:side, :side] = cv2.resize(astronaut, (side, side))
    take = load(open_recording(film([picture] * 8, fps=fps)))
    assert take.positions.shape == (8, 33, 3)
    assert np.allclose(np.diff(take.times), 1 / fps, atol=1e-3)


@needs_ffmpeg
def test_rotation_is_honoured(film, astronaut, tmp_path):
    path = film([astronaut[:, :400]] * 3)
    turned = tmp_path / "turned.mp4"
    command = ["ffmpeg", "-v", "error", "-i", path, "-c", "copy", "-metadata:s:v", "rotate=90", turned]
    if subprocess.run(command, check=False, capture_output=True).returncode:
        pytest.skip("this ffmpeg writes no rotation")
    shapes = {picture.shape for picture, _ in pictures(turned)}
    assert shapes == {(400, 512, 3)}


@needs_ffmpeg
def test_variable_rates_keep_their_times(film, pan, tmp_path):
    path = film(pan[:20], fps=25.0)
    varied = tmp_path / "varied.mp4"
    steps = ["-vf", "select='not(eq(mod(n,4),1))'", "-fps_mode", "vfr", "-c:v", "mpeg4"]
    subprocess.run(["ffmpeg", "-v", "error", "-i", path, *steps, varied], check=True)
    times = np.array([time for _, time in pictures(varied)])
    assert sorted({round(step, 2) for step in np.diff(times)}) == [0.04, 0.08]


def test_a_video_says_how_long_it_is(film, pan):
    video = describe(film(pan, fps=50.0))
    assert (video.count, video.fps) == (60, 50.0)
