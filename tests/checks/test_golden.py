"""Golden events: a folder of results is equal to itself, and one changed number is named."""

import gzip

import numpy as np

from checks.golden import Options, compare, write


def _results(folder, out):
    write("random", Options(folder, 1, 7), out)


def test_the_same_version_says_the_same_twice(tmp_path, capsys):
    _results(tmp_path, tmp_path / "one")
    _results(tmp_path, tmp_path / "other")
    assert compare(tmp_path / "one", tmp_path / "other", ["random"], 3)
    assert "all: 1 equal" in capsys.readouterr().out


def test_a_changed_number_is_named_with_its_line(tmp_path, capsys):
    for name in ("one", "other"):
        _results(tmp_path, tmp_path / name)
    (path,) = (tmp_path / "other").rglob("*.gz")
    lines = gzip.decompress(path.read_bytes()).decode().splitlines()
    lines[2] = lines[2].replace('"v":1', '"v":2')
    path.write_bytes(gzip.compress("\n".join(lines).encode()))
    assert not compare(tmp_path / "one", tmp_path / "other", ["random"], 3)
    assert "line 3, 1 of" in capsys.readouterr().out


def test_a_missing_case_is_a_difference(tmp_path):
    _results(tmp_path, tmp_path / "one")
    assert not compare(tmp_path / "one", tmp_path / "none", ["random"], 3)


def test_a_small_recording_is_written_streamed_and_whole(tmp_path, capsys):
    folder = tmp_path / "labelled" / "set"
    folder.mkdir(parents=True)
    positions = np.zeros((60, 2, 3), np.float32)
    positions[20:40, 1, 0] = np.linspace(0, 1, 20)
    positions[40:, 1, 0] = 1
    np.savez(folder / "a.npz", positions=positions, fps=30.0, joint_names=["hip", "hand"], parents=[-1, 0])
    (folder / "a.json").write_text('{"recording": "a.npz", "cuts": [[20, 20, 20]]}')
    write("streams", Options(tmp_path, 0, 1), tmp_path / "out")
    write("recordings", Options(tmp_path, 0, 1), tmp_path / "out")
    assert "streams: 9 cases, 0 refused" in capsys.readouterr().out
