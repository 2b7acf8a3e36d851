import io
import json

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.jsonlines import JsonLinesSource
from mossar_adapters.source import Meta
from mossar_stream import Frames, MossarError


def source(*maps, **options):
    lines = [m if isinstance(m, bytes) else json.dumps(m).encode() for m in maps]
    return JsonLinesSource(
        parse_url("-"), ReadOptions(**options), io.BytesIO(b"".join(line + b"\n" for line in lines))
    )


def frame(**fields):
    return {"type": "frame", "xyz": [[0, 1, 0], [0, 2, None]], **fields}


META = {"type": "meta", "names": ["hip", "head"], "parents": [-1, 0], "fps": 50}


def frames_of(read):
    return [item for item in read.items() if isinstance(item, Frames)]


def test_metas_and_frames_come_in_order():
    items = list(source(META, frame(t=1.0), frame(t=1.1)).items())
    assert isinstance(items[0], Meta)
    assert items[0].skeleton.names == ("hip", "head")
    assert items[1].times.tolist() == [1.0, 1.1]
    assert np.isnan(items[1].positions[0, 1]).any()


def test_times_are_the_senders_else_by_the_rate():
    assert frames_of(source(META, frame(), frame()))[0].times.tolist() == [0.0, 0.02]
    assert frames_of(source(META, frame(), frame(), fps=10))[0].times.tolist() == [0.0, 0.1]


def test_a_skeleton_is_made_up_for_frames_without_meta():
    items = list(source(frame(t=0.0)).items())
    assert len(items[0].skeleton) == 2


def test_broken_lines_are_counted_and_passed_over():
    read = source(META, b"hello", frame(t=0.0), frame(t=0.1, xyz=[[0, 1]]), b"[" * 3000, frame(t=0.2))
    assert [len(frames) for frames in frames_of(read)] == [2]
    assert read.counters.malformed == 3
    assert "malformed (line 2: " in read.explain()


@pytest.mark.parametrize("text", [b"", b"\n\n", b"hello", b'{"type":"key_frame"}', b"x" * 3_000_000])
def test_no_frame_at_all_is_an_error(text):
    with pytest.raises(MossarError, match="there is no frame in it"):
        list(source(text).items())


def test_a_line_too_long_takes_no_memory_and_is_counted():
    read = source(META, frame(t=0.0), b"x" * 3_000_000)
    assert len(frames_of(read)) == 1
    assert read.counters.malformed > 0
