"""Damaged files of every format: clean errors or sane frames, nothing else."""

import random
import re

import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_recording

ODD_WORDS = (
    b"-1",
    b"0",
    b"99999999999",
    b"1e308",
    b"nan",
    b"-inf",
    b"",
    b"abc",
    b"\xe9",
    b"9" * 300,
    b"{",
    b"]",
    b'"',
    b"null",
)
ODD_COUNTS = (b"\xff\xff\xff\xff", b"\x00\x00\x00\x00", b"\xff\xff\xff\x7f", b"\x00\x00\x00\x80")


def damaged(data, rng):
    """Return data with one to three places cut, flipped, overwritten, doubled or replaced."""
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(min(len(data), 1500) if rng.random() < 0.5 else len(data))
        words = [m.span() for m in re.finditer(rb"[^\s,:]+", data[at : at + 200])]
        match rng.randrange(6):
            case 0:
                data = data[: at + 1]
            case 1:
                data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
            case 2:
                data = data[:at] + rng.choice(ODD_COUNTS) + data[at + 4 :]
            case 3:
                data = data[:at] + data[at + rng.randrange(200) :] or b"x"
            case 4:
                data = data[:at] + data[at : at + 300] + data[at:]
            case _ if words:
                start, end = rng.choice(words)
                data = data[: at + start] + rng.choice(ODD_WORDS) + data[at + end :] or b"x"
            case _:
                pass
    return data


def check(path):
    """Read a recording and check what every reader promises."""
    recording = open_recording(path, ReadOptions(allow_2d=True))
    count = 0
    for frames in recording.chunks():
        count += len(frames)
        assert frames.positions.dtype in (np.float32, np.float64)
        assert frames.positions.shape == (len(frames.times), len(recording.skeleton), 3)
        assert np.isfinite(frames.times).all()
        assert not np.isinf(frames.positions).any()
        assert frames.performer in recording.performers
    assert count == recording.frame_count > 0
    assert recording.fps is None or 0 < recording.fps <= 1e6


@pytest.mark.parametrize("seed", range(3))
def test_damage_is_a_clean_error_or_sane_frames(sample, kind, seed):
    rng = random.Random(f"{kind} {seed}")
    path = sample(kind)
    whole = path.read_bytes()
    for _ in range(50):
        path.write_bytes(damaged(whole, rng))
        try:
            check(path)
        except FileError as error:
            assert "\n" not in str(error)  # noqa: PT017 - either outcome is right
