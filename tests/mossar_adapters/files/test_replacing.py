import os

import pytest

from mossar_adapters.annotations.writing import write_annotations
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.replacing import Draft, check_places


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with files, which is the current one."""
    monkeypatch.chdir(tmp_path)
    for name in ("take.msk", "b.msk", "walk.amc", "man.asf", "dance.mp4", "dance.mp4.pose.npz", "own.key"):
        (tmp_path / name).write_text(name, encoding="utf-8")
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / "walk.json").write_text("{}", encoding="utf-8")
    (tmp_path / "link.csv").symlink_to("take.msk")
    os.link("take.msk", "hard.csv")
    return tmp_path


CLASHES = {
    "the same path": (["take.msk"], ["take.msk"]),
    "another spelling": (["take.msk"], ["./set/../take.msk"]),
    "a file: URL": (["file:take.msk"], ["take.msk"]),
    "a symbolic link": (["take.msk"], ["link.csv"]),
    "a hard link": (["take.msk"], ["hard.csv"]),
    "one of a pattern": (["*.msk"], ["b.msk"]),
    "a skeleton beside": (["walk.amc"], ["man.asf"]),
    "poses beside a video": (["dance.mp4"], ["dance.mp4.pose.npz"]),
    "a skeleton in a URL": (["osc://127.0.0.1:9000?skeleton=own.key"], ["own.key"]),
    "a key of a sink": ([], ["zmq+bind://127.0.0.1:5556?key=own.key", "own.key"]),
    "a label in a folder": (["set"], ["set/walk.json"]),
    "two outputs": ([], ["a.csv", "a.csv"]),
    "two outputs by a link": ([], ["hard.csv", "take.msk"]),
    "two outputs that are not there yet": ([], ["set/new.csv", "set/../set/new.csv"]),
    "standard output twice": ([], ["-", "-"]),
}


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("read", "written"), CLASHES.values(), ids=CLASHES)
def test_what_is_read_is_not_written_and_nothing_is_written_twice(read, written):
    with pytest.raises(FileError, match="nothing can be both"):
        check_places(read, written)


FINE = {
    "another file": (["take.msk"], ["take.csv"]),
    "a new file in a folder that is read": (["set"], ["set/new.json"]),
    "a picture beside labels": (["set"], ["set/walk.png"]),
    "an input twice": (["take.msk", "take.msk"], ["a.csv"]),
    "a device twice": (["take.msk"], ["/dev/null", "/dev/null"]),
    "both ends of a pipe": (["-"], ["-"]),
    "other URLs": (["osc://127.0.0.1:9000", "demo:?seed=1"], ["osc://127.0.0.1:9001", "zmq+bind://*:5556"]),
}


@pytest.mark.parametrize(("read", "written"), FINE.values(), ids=FINE)
def test_other_places_may_be_written(folder, read, written):
    (folder / "set" / "walk.png").write_bytes(b"")
    check_places(read, written)


def test_a_draft_takes_the_place_of_a_file_at_the_end(tmp_path):
    target = tmp_path / "a.csv"
    target.write_text("old", encoding="utf-8")
    target.chmod(0o640)
    with Draft(target) as draft:
        draft.path.write_text("new", encoding="utf-8")
        assert target.read_text(encoding="utf-8") == "old"
        assert draft.path.suffix == ".csv", "libraries choose the format by it"
    assert target.read_text(encoding="utf-8") == "new"
    assert target.stat().st_mode & 0o777 == 0o640
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_an_error_leaves_the_old_file_and_nothing_beside(tmp_path):
    target = tmp_path / "a.csv"
    target.write_text("old", encoding="utf-8")
    with pytest.raises(ZeroDivisionError), Draft(target) as draft:
        draft.path.write_text(f"half {1 / 0}", encoding="utf-8")
    assert target.read_text(encoding="utf-8") == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_what_a_link_points_to_is_replaced(tmp_path):
    (tmp_path / "real.csv").write_text("old", encoding="utf-8")
    (tmp_path / "link.csv").symlink_to("real.csv")
    with Draft(tmp_path / "link.csv") as draft:
        draft.path.write_text("new", encoding="utf-8")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_text(encoding="utf-8") == "new"


@pytest.mark.parametrize("suffix", [".eaf", ".etf", ".TextGrid", ".vtt"])
def test_annotations_that_cannot_be_written_leave_the_old_ones(tmp_path, monkeypatch, suffix):
    pytest.importorskip("pympi")
    target = tmp_path / f"a{suffix}"
    target.write_text("old", encoding="utf-8")

    def full(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr("pathlib.Path.replace", full)
    with pytest.raises(Exception, match="full"):
        write_annotations(target, [], 1.0)
    assert target.read_text(encoding="utf-8") == "old"
    assert [path.name for path in tmp_path.iterdir()] == [target.name]
