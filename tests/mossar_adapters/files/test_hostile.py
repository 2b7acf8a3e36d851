"""Small files made to take time or memory."""

import io
import time
import zipfile

import numpy as np
import pytest

from mossar_adapters.files import FileError, open_recording

MEBIBYTE = 1 << 20
BLANKS = "\n" * MEBIBYTE
CASES = {
    "a.amc": BLANKS + "1" + BLANKS + "root",
    "b.amc": "1\nroot " + "1 " * MEBIBYTE,
    "a.skeleton": "1" + BLANKS + "x",
    "a.bvh": "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 0\n}\nMOTION\nFrames" + " " * MEBIBYTE + "x\n",
    "b.bvh": "HIERARCHY\n" + "ROOT a\n{\n" * 300_000,
    "c.bvh": "HIERARCHY\n" + "JOINT a {\n" * 1000 + "}" * 1000 + "\nMOTION\nFrames: 1\nFrame Time: 1\n\n",
    "a.csv": "." * MEBIBYTE + "_x,a_y,a_z\n1,2,3\n",
    "b.csv": "a" * MEBIBYTE + "\n" + "x," * MEBIBYTE,
    "c.csv": "t,a_x,a_y,a_z\n1 day" + " " * MEBIBYTE + "s,1,2,3\n",
    "d.csv": "a_x,a_y,a_z\n" + "9" * MEBIBYTE + ",1,2\n",
    "e.csv": 'a_x,a_y,a_z\n"' + "9" * MEBIBYTE + '",1,2\n"' + "\n",
    "f.csv": "Format Version,1\n" + '"' + "a" * MEBIBYTE + "\n",
    "g.csv": ",".join(f"{k}_{axis}" for k in range(5000) for axis in "xyz") + "\n" + "1," * 15_000,
    "h.csv": ",".join("_.:/- " * 25 + str(k) for k in range(15_000)) + "\n" + "1," * 15_000,
    "a.trc": "PathFileType" + " " * MEBIBYTE + BLANKS,
    "a.tsv": "NO_OF_FRAMES\t" + "9" * MEBIBYTE,
    "a.json": "[" * MEBIBYTE,
    "b.json": '{"frames": ' + "[[]," * (MEBIBYTE // 4),
    "c.json": '{"fps": ' + "9" * 5000 + ', "frames": []}',
    "d.json": '"' + "\\" * MEBIBYTE,
    "e.json": '{"NaN' + '\\"' * MEBIBYTE + " NaN",
    "f.json": '{"' + "frame_" * MEBIBYTE + '1": [[1, 2, 3], [4, 5, 6]]}',
    "a.jsonl": '{"type": "frame", "xyz": ' + "[" * MEBIBYTE + "}\n",
}


@pytest.mark.parametrize("name", CASES)
def test_text_made_to_take_time_is_read_or_refused_at_once(tmp_path, name):
    (tmp_path / name).write_text(CASES[name])
    (tmp_path / "a.asf").write_text(":root\n:bonedata\n:hierarchy\n")
    start = time.process_time()
    try:
        assert sum(len(frames) for frames in open_recording(tmp_path / name).chunks()) == 1
    except FileError as error:
        assert "\n" not in str(error)  # noqa: PT017 - either outcome is right
        assert len(str(error)) < 600  # noqa: PT017
    assert time.process_time() - start < 5


def archive(path, *, packing=zipfile.ZIP_DEFLATED, **members):
    with zipfile.ZipFile(path, "w", packing) as file:
        for name, content in members.items():
            file.writestr(f"{name}.npy", content)
    return path


def array_bytes(array, old=b"", new=b""):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue().replace(old, new)


GOOD = array_bytes(np.ones((3, 2, 3)))
HUGE = b"(99999999999,), }"


@pytest.mark.parametrize(
    "members",
    [
        {"positions": array_bytes(np.ones((3, 2, 3)), b"(3, 2, 3), }       ", b"(999999999, 2, 3), }")},
        {"positions": GOOD, "fps": array_bytes(np.ones(1), b"(1,), }" + b" " * 10, HUGE)},
        {"positions": GOOD, "times": array_bytes(np.ones(3), b"(3,), }" + b" " * 10, HUGE)},
        {"positions": array_bytes(np.ones((3, 2, 3)), b"(3, 2, 3), }", b"(3, 2, 3,( }")},
        {"positions": b"\x93NUMPY\x01\x00\xff\xff" + b"(" * 65535},
        {"positions": b"\x93NUMPY\x02\x00\xff\xff\xff\xff" + b" " * 100},
        {"positions": b""},
    ],
)
def test_archives_with_headers_that_lie_are_refused_without_taking_memory(tmp_path, members):
    with pytest.raises(FileError):
        open_recording(archive(tmp_path / "a.npz", **members))


def test_archives_packed_otherwise_than_numpy_does_are_refused(tmp_path):
    with pytest.raises(FileError, match="packed in a way that numpy does not write"):
        open_recording(archive(tmp_path / "a.npz", packing=zipfile.ZIP_LZMA, positions=GOOD))
