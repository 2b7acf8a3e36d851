"""`mossar flink` and `mossar archive`: what is told before an engine starts."""

import pytest

from mossar_adapters.extras import installed

JOB = '[source]\nfiles = "frames"\n'


def assert_refused(result, message):
    status, out, err = result
    assert (status, out) == (2, "")
    assert message in err
    assert len(err.splitlines()) == 1


def test_a_job_that_cannot_be_read_is_wrong_usage(mossar, tmp_path):
    assert_refused(mossar("flink", tmp_path / "no.toml"), "no.toml: cannot be read: No such file")
    path = tmp_path / "job.toml"
    path.write_text("parallelism = 2\n")
    assert_refused(mossar("flink", path), "job.toml: there must be a key `source`")


def test_what_is_missing_on_the_command_line_is_named(mossar, tmp_path):
    assert_refused(mossar("flink"), "required: JOB.toml")
    assert_refused(mossar("archive", tmp_path), "required: OUT")


def test_settings_of_an_archive_are_checked_first(mossar, tmp_path):
    assert_refused(
        mossar("archive", tmp_path, tmp_path / "out", "--set", "window=99"), "setting window is 99"
    )


@pytest.mark.skipif(installed("pyflink"), reason="the extra flink is installed")
def test_a_missing_flink_is_named(mossar, tmp_path):
    path = tmp_path / "job.toml"
    path.write_text(JOB)
    assert_refused(mossar("flink", path), "pip install 'mossar-stream[flink]'")


@pytest.mark.skipif(installed("ray"), reason="the extra archive is installed")
def test_a_missing_ray_is_named(mossar, tmp_path):
    assert_refused(mossar("archive", tmp_path, tmp_path / "out"), "pip install 'mossar-stream[archive]'")


@pytest.mark.skipif(not installed("ray"), reason="the extra archive is not installed")
def test_places_without_recordings_are_wrong_usage(mossar, tmp_path):
    out = tmp_path / "out"
    assert_refused(mossar("archive", tmp_path / "no", out), "no: there is no such folder")
    (tmp_path / "in").mkdir()
    assert_refused(mossar("archive", tmp_path / "in", out), "there is no recording in it")
    (tmp_path / "in" / "a.bvh").touch()
    assert_refused(mossar("archive", tmp_path / "in", "nowhere://x/y"), "nowhere://x/y: ")
    (out / "mine").mkdir(parents=True)
    (out / "mine" / "thesis.txt").touch()
    assert_refused(mossar("archive", tmp_path / "in", out), "it is not empty; --resume continues")
    assert_refused(mossar("archive", tmp_path / "in", out, "--resume"), "holds other things than a job")
    assert (out / "mine" / "thesis.txt").exists()
