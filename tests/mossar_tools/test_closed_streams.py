"""Standard streams that whoever started the program has closed."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(os.name != "posix", reason="a shell of POSIX systems closes them")


@pytest.mark.parametrize(
    ("closed", "source", "status", "said"),
    [
        (">&-", "demo:?seconds=1", 0, b""),
        ("2>&-", "demo:?seconds=1", 0, b""),
        ("<&- >&- 2>&-", "demo:?seconds=1", 0, b""),
        ("<&-", "-", 1, b"standard input: there is no frame in it"),
    ],
)
def test_a_closed_stream_is_neither_a_traceback_nor_waited_for(tmp_path, closed, source, status, said):
    words = "run --quiet --force --speed max --to" if source != "-" else "run --to"
    command = f'"{sys.executable}" -m mossar_tools {words} e.jsonl "{source}" {closed}'
    places = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        command, shell=True, cwd=tmp_path, env=places, capture_output=True, timeout=120, check=False
    )
    assert done.returncode == status, done.stderr
    assert b"Traceback" not in done.stderr
    assert said in done.stderr
    if source != "-":
        assert (tmp_path / "e.jsonl").read_bytes().count(b"\n") > 1
