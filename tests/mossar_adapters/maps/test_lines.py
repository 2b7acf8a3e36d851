"""The decoder of JSON lines: the same frames in whatever pieces the bytes come."""

import json

import numpy as np
import pytest

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.maps.codec import to_json
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap
from mossar_adapters.maps.lines import MAX_LINE, LineDecoder
from mossar_adapters.source import Meta
from mossar_stream import Frames

META = MetaMap(("hip", "head"), parents=(-1, 0), fps=50.0)
LINES = [META, *(FrameMap(xyz=[[0.0, 1.0, k / 10], None], t=None if k == 3 else k / 50) for k in range(8))]
TEXT = b"\n".join(map(to_json, LINES))


def decoded(data, size, **options):
    decoder = LineDecoder(ReadOptions(**options))
    found = [item for i in range(0, len(data), size) for item in decoder.receive(data[i : i + size], 0.0)]
    return decoder, found + decoder.end(0.0)


def joined(items, field):
    return np.concatenate([getattr(item, field) for item in items if isinstance(item, Frames)])


@pytest.mark.parametrize("size", [1, 7, 64])
def test_bytes_give_the_same_frames_however_they_are_cut(size):
    _, whole = decoded(TEXT, len(TEXT))
    decoder, pieces = decoded(TEXT, size)
    assert [item for item in pieces if isinstance(item, Meta)] == whole[:1]
    for field in ("times", "positions"):
        assert np.array_equal(joined(pieces, field), joined(whole, field), equal_nan=True)
    assert len(joined(pieces, "times")) == 8
    assert (decoder.usable, decoder.counters.malformed) == (8, 0)


def test_the_last_line_needs_no_end():
    decoder, found = decoded(to_json(LINES[1]), 100)
    assert [type(item) for item in found] == [Meta, Frames]
    assert decoder.end(0.0) == []


def test_a_line_without_end_takes_no_memory():
    decoder = LineDecoder()
    for _ in range(64):
        assert decoder.receive(b"x" * (MAX_LINE // 8), 0.0) == []
        assert len(decoder._rest) <= MAX_LINE
    assert decoder.counters.malformed == 7
    assert decoder.problem.endswith("bytes)")


@pytest.mark.parametrize("fps", [-3, 0.0001, 1e300])
def test_an_impossible_rate_is_refused_and_nobody_else_has_it(fps):
    decoder = LineDecoder()
    lines = [
        {"type": "meta", "performer": "eve", "names": ["a", "b"], "fps": fps},
        {"type": "frame", "performer": "ann", "t": 1.5, "xyz": [[0, 1, 0], [0, 2, 0]]},
    ]
    found = decoder.receive(b"".join(json.dumps(line).encode() + b"\n" for line in lines), 0.0)
    meta, frames = found
    assert (meta.performer, meta.fps) == ("ann", None)
    assert frames.times.tolist() == [1.5]
    assert decoder.counters.malformed == 1
