import pytest

from mossar_adapters.pipeline.snapshot import Position, Snapshot, read_snapshot, sealed, write_snapshot
from mossar_stream import SnapshotError


def test_a_snapshot_is_read_as_it_was_written_and_leaves_nothing_beside(tmp_path):
    path = tmp_path / "state"
    snapshot = Snapshot(
        b"{}", complete=False, sources=(Position("a.bvh", {"p1": 7}, {"p1": "p2"}),), performers={"p2": b"x"}
    )
    for _ in range(2):
        write_snapshot(path, snapshot)
    assert read_snapshot(path) == snapshot
    assert [p.name for p in tmp_path.iterdir()] == ["state"]


def test_no_file_is_no_snapshot(tmp_path):
    assert read_snapshot(tmp_path / "state") is None


def test_something_else_is_refused_with_one_line(tmp_path):
    path = tmp_path / "state"
    right = sealed(b"\x81\xa1v\x01")
    for content in (b"", b"hello", b"MSNAP", b"MSNAP\xc1", b"MSNAP" + b"\x81\xa1v\x01", right, right[:-1]):
        path.write_bytes(content)
        with pytest.raises(SnapshotError, match="delete it to start anew") as caught:
            read_snapshot(path)
        assert "\n" not in str(caught.value)


def test_every_damaged_byte_is_noticed(tmp_path):
    path = tmp_path / "state"
    write_snapshot(path, Snapshot(b"{}", complete=False, performers={"p1": b"something"}))
    whole = path.read_bytes()
    for place in range(len(whole)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x40]) + whole[place + 1 :])
        with pytest.raises(SnapshotError, match="delete it to start anew"):
            read_snapshot(path)


def test_a_newer_snapshot_is_refused_by_its_version(tmp_path):
    path = tmp_path / "state"
    write_snapshot(path, Snapshot(b"{}", complete=False))
    path.write_bytes(path.read_bytes().replace(b"MSNAP\x04", b"MSNAP\x05"))
    with pytest.raises(SnapshotError, match="of version 5, this program reads version 4"):
        read_snapshot(path)


def test_a_place_that_cannot_be_written_is_an_error(tmp_path):
    with pytest.raises(SnapshotError, match="cannot be written"):
        write_snapshot(tmp_path / "no" / "state", Snapshot(b"", complete=True))


def test_a_link_in_the_place_of_the_file_beside_is_not_followed(tmp_path):
    dear = tmp_path / "dear.txt"
    dear.write_text("dear to somebody")
    (tmp_path / "state.new").symlink_to(dear)
    write_snapshot(tmp_path / "state", Snapshot(b"{}", complete=True))
    assert dear.read_text() == "dear to somebody"
    assert read_snapshot(tmp_path / "state").complete


def test_what_could_not_be_read_is_not_written(tmp_path, monkeypatch):
    path = tmp_path / "state"
    write_snapshot(path, Snapshot(b"{}", complete=False, performers={"p1": b"something"}))
    monkeypatch.setattr("mossar_adapters.pipeline.snapshot.MAX_BYTES", 1000)
    with pytest.raises(SnapshotError, match="can be read; it is not written"):
        write_snapshot(path, Snapshot(b"{}", complete=False, performers={"p1": bytes(1001)}))
    assert read_snapshot(path).performers == {"p1": b"something"}
