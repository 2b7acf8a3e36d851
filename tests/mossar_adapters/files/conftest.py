"""Small recordings of every format in a folder of their own."""

from pathlib import Path

import pytest

from checks.fuzz.recordings import ASF, WRITERS


@pytest.fixture(params=sorted(WRITERS))
def kind(request):
    return request.param


@pytest.fixture
def sample(tmp_path):
    """Return a function that writes the small recording of a format and returns its path."""

    def write(kind, **how) -> Path:
        name, content = WRITERS[kind]
        path = tmp_path / name
        (tmp_path / "a.asf").write_bytes(ASF)
        path.write_bytes(content(**how))
        return path

    return write


@pytest.fixture
def shared():
    """Return the folder of real recordings beside the project."""
    folder = Path(__file__).parents[4] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"the real recordings are not here ({folder})")
    return folder
