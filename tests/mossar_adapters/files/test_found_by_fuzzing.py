"""Inputs that once ended a reader with something else than a clear error; `python -m checks.fuzz` found them."""

import pytest

from mossar_adapters.files import FileError, open_recording

CASES = {
    "parents.csv": b"# parents=--1,0\na.x,a.y,a.z,b.x,b.y,b.z\n1,2,3,4,5,6\n",
    "number.json": b'{"people": [{"pose_keypoints_3d": 1.3}]}',
}


@pytest.mark.parametrize("name", CASES)
def test_it_is_refused_with_a_clear_error(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(CASES[name])
    with pytest.raises(FileError):
        open_recording(path)
