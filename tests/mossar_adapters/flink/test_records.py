"""Records: what goes in comes out, and what others send is refused in one line."""

import msgspec
import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.flink.records import MAX_BYTES, NOBODY, performer_of, read_record, records_of
from mossar_adapters.maps.codec import to_json, to_msgpack
from mossar_adapters.maps.frame_maps import map_of_meta, maps_of_frames
from mossar_adapters.source import Meta
from mossar_stream import FrameError, Frames, Skeleton

GOOD = {"type": "frames", "t": [0.5], "shape": [1, 2, 3], "xyz": bytes(24)}


def frames(count=7, joints=4, confidence=False, first_frame=None):
    rng = np.random.default_rng(1)
    positions = rng.normal(0, 1, (count, joints, 3)).astype(np.float32)
    positions[0, 1] = np.nan
    sure = rng.random((count, joints)).astype(np.float32) if confidence else None
    return Frames(positions, np.arange(count) / 60, sure, "ann", first_frame)


@pytest.mark.parametrize("text", [True, False])
@pytest.mark.parametrize("confidence", [True, False])
@pytest.mark.parametrize("first_frame", [None, 5])
def test_frames_come_back_as_they_were(text, confidence, first_frame):
    whole = frames(confidence=confidence, first_frame=first_frame)
    records = list(records_of(whole, 3, text=text))
    assert len(records) == 3
    assert {performer_of(record) for record in records} == {"ann"}
    found = [read_record(record) for record in records]
    assert [one.first_frame for one in found] == ([None] * 3 if first_frame is None else [5, 8, 11])
    np.testing.assert_array_equal(np.concatenate([one.positions for one in found]), whole.positions)
    np.testing.assert_array_equal(np.concatenate([one.times for one in found]), whole.times)
    if confidence:
        np.testing.assert_array_equal(np.concatenate([one.confidence for one in found]), whole.confidence)


@pytest.mark.parametrize("text", [True, False])
def test_a_meta_comes_back_as_it_was(text):
    meta = Meta("ann", Skeleton(("hip", "hand"), (-1, 0)), 60.0)
    (record,) = records_of(meta, text=text)
    assert read_record(record) == meta
    assert performer_of(record) == "ann"


def test_text_and_bytes_of_a_line_are_the_same_record():
    (line,) = records_of(frames(), text=True)
    assert performer_of(line.decode()) == "ann"
    np.testing.assert_array_equal(read_record(line.decode()).positions, read_record(line).positions)


@pytest.mark.parametrize("encode", [to_json, to_msgpack])
def test_the_maps_of_zeromq_and_json_lines_are_records(encode):
    whole = frames(2, confidence=True)
    meta = Meta("ann", Skeleton(tuple("abcd")))
    assert read_record(encode(map_of_meta(meta))) == meta
    found = [read_record(encode(one)) for one in maps_of_frames(whole, 0)]
    np.testing.assert_array_equal(np.concatenate([one.positions for one in found]), whole.positions)
    assert [one.times.tolist() for one in found] == [[0.0], [1 / 60]]
    np.testing.assert_allclose(np.concatenate([one.confidence for one in found]), whole.confidence, rtol=1e-6)


def test_what_is_out_of_this_world_is_missing():
    record = msgspec.msgpack.encode({**GOOD, "xyz": np.array([np.inf, 0, 0, 1e9, 0, 0], "<f4").tobytes()})
    assert np.isnan(read_record(record).positions).all()


@pytest.mark.parametrize(
    ("record", "message"),
    [
        (b"", "truncated"),
        (b"\xc1", "type|invalid|malformed"),
        (b"{", "truncated"),
        (b"[1, 2]", "Expected `object`"),
        (b"{" * 100_000, "."),
        (b" " * (MAX_BYTES + 1), "bytes; 1048576 can be read"),
        ({"type": "pose"}, "a record of type 'pose'; there are frames, frame, meta"),
        ({"type": "frames"}, "missing required field"),
        ({**GOOD, "t": [1.0, 2.0]}, "2 times with a shape of"),
        ({**GOOD, "t": [float("nan")]}, "no time"),
        ({**GOOD, "t": [1e300]}, "no time"),
        ({**GOOD, "shape": [1, 3, 3]}, "xyz has 24 bytes"),
        ({**GOOD, "shape": [1, 0, 3], "xyz": b""}, "shape"),
        ({**GOOD, "shape": [1, 2, 2]}, "shape"),
        ({**GOOD, "shape": [-1, 2, 3], "t": []}, "shape"),
        ({**GOOD, "shape": [1, 1 << 40, 3]}, "shape"),
        ({**GOOD, "conf": b"1"}, "conf has 1 bytes"),
        ({**GOOD, "first_frame": -1}, "first_frame is -1"),
        ({"type": "frame", "xyz": bytes(12)}, "without a time"),
        ({"type": "meta", "names": []}, "1 to 1024 joints"),
        ({"type": "meta", "names": ["a"], "unit": "cm"}, "in metres"),
    ],
)
def test_an_impossible_record_is_refused(record, message):
    data = msgspec.msgpack.encode(record) if isinstance(record, dict) else record
    with pytest.raises(FrameError, match=message):
        read_record(data)


@pytest.mark.parametrize("record", [b"", b"{", b"\xc1", b"[]", "nothing", b'{"performer": 3}'])
def test_a_record_that_cannot_be_read_has_no_performer(record):
    assert performer_of(record) == NOBODY


def test_performers_are_named_as_everywhere():
    assert performer_of(b'{"type":"frames","performer":"10.0.0.7/a b"}') == "10_0_0_7_a_b"
    assert performer_of(b'{"type":"frames"}') == "p1"


def test_a_source_becomes_records():
    items = list(DemoSource.from_url("demo:?seconds=1&performers=2", speed="max").items())
    found = [read_record(record) for item in items for record in records_of(item)]
    assert sum(len(one) for one in found if isinstance(one, Frames)) == 120
