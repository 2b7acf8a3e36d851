"""Jobs: what the file says is checked before anything starts."""

import re
from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.flink import job as job_module
from mossar_adapters.flink.job import read_job
from mossar_stream import Moves, SettingsError, Skeleton

FILES = '[source]\nfiles = "frames"\n'


def written(tmp_path, text):
    path = tmp_path / "job.toml"
    path.write_text(text)
    return path


def test_the_least_that_a_job_says(tmp_path):
    job = read_job(written(tmp_path, FILES))
    assert job.source.files == (tmp_path / "frames").as_uri()
    assert job.checkpoints.folder == (tmp_path / "checkpoints").as_uri()
    assert (job.to.live, job.parallelism, job.takes.idle) == ("-", 1, 5.0)


def test_the_example_in_the_module_is_a_job(tmp_path):
    text = re.sub(
        r"^    ", "", job_module.__doc__.split("\n\n", 1)[1].rsplit("\n\nPaths", 1)[0], flags=re.MULTILINE
    )
    assert read_job(written(tmp_path, text)).segmenter.build().window == 0.25
    other = re.sub(r"^(files|live) = .*$", "", text, flags=re.MULTILINE).replace("# kafka", "kafka")
    job = read_job(written(tmp_path, other))
    assert job.source.kafka.topic == "frames"
    assert job.to.kafka.guarantee == "at-least-once"


def test_buckets_stay_as_they_are(tmp_path):
    job = read_job(written(tmp_path, FILES + '[to]\nfiles = "s3://b/events"\n'))
    assert job.to.files == "s3://b/events"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "there must be a key `source`"),
        ("x = 1\n" + FILES, "there is no key `x`; there are source, to, name"),
        ("a = [", "not valid TOML"),
        ('[source]\nfile = "a"', "source: there is no key `file`; there are files, kafka"),
        ("[source]", "[source] takes one of files, kafka; there is none"),
        ("[source]\nfiles = 3", "source.files: expected `str | null`, got `int`"),
        ('[source]\nfiles = ""', "source.files: expected `str` of length >= 1"),
        ('[source.kafka]\nservers = "a:1"', "source.kafka: there must be a key `topic`"),
        (
            '[source.kafka]\nservers = "a:1"\ntopic = "t"\nbegin = "now"',
            "source.kafka.begin: there is no 'now'; there are committed, earliest, latest",
        ),
        (
            FILES + '[to]\nlive = "-"\nfiles = "x"',
            "[to] takes one of live, files, kafka; there is live and files",
        ),
        (FILES + '[to]\nlive = "a.jsonl"', 'use files = "FOLDER"'),
        (FILES + '[to]\nlive = "foo://x"', "there is no sink foo:; there are"),
        (FILES + '[segmenter]\nlevel = "strong"', "it must be posture, motion, cluster"),
        (
            FILES + '[segmenter]\npreset = "fast"',
            "segmenter.preset: there is no 'fast'; there are paper, default, game",
        ),
        (FILES + "[segmenter.settings]\nwindow = 99", "setting window is 99"),
        (FILES + '[segmenter.settings]\nrange = "file"', "needs a whole recording"),
        (FILES + '[segmenter]\nmoves = "no.json"', "no.json: cannot be read: No such file"),
        (FILES + '[segmenter]\nmoves = "job.toml"', "job.toml: this is not a file of moves"),
        (FILES + "[takes]\nidle = 7200", "takes.forget must be longer than takes.idle"),
        (FILES + "[takes]\nidle = -1", "takes.idle: expected `float` >= 0"),
        (FILES + "[checkpoints]\nseconds = 0", "checkpoints.seconds: expected `float` >= 0.1"),
        ("parallelism = 0\n" + FILES, "parallelism: expected `int` >= 1"),
        (FILES + "[flink]\na = [1]", "flink[...]: expected"),
    ],
)
def test_a_wrong_job_is_refused_in_one_line_with_its_place(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(SettingsError) as caught:
        read_job(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_said(tmp_path):
    with pytest.raises(SettingsError, match="cannot be read: No such file"):
        read_job(Path(tmp_path, "no.toml"))
    path = tmp_path / "binary.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(SettingsError, match="not valid TOML"):
        read_job(path)
    with pytest.raises(SettingsError, match="larger than 1 MB"):
        read_job(written(tmp_path, "#" * (1 << 20) + "#"))


def test_moves_lie_beside_the_job(tmp_path):
    moves = Moves(Skeleton(("hip", "hand"), (-1, 0)))
    wave = np.zeros((30, 2, 3))
    wave[:, 1, 0] = np.sin(np.linspace(0, 6, 30))
    moves.add("wave", wave, 30)
    moves.save(tmp_path / "moves.json")
    job = read_job(written(tmp_path, FILES + '[segmenter]\nmoves = "moves.json"\n'))
    assert job.segmenter.read_moves().examples == moves.examples
    assert read_job(written(tmp_path, FILES)).segmenter.read_moves() is None
