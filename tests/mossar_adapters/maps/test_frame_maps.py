import msgspec
import numpy as np
import pytest

from mossar_adapters.maps.frame_maps import (
    FrameMap,
    MetaMap,
    confidence_of_map,
    map_of_meta,
    maps_of_frames,
    meta_of_map,
    positions_of_map,
)
from mossar_adapters.source import Meta
from mossar_stream import FrameError, Frames, Skeleton


@pytest.mark.parametrize("fps", [None, 60.0])
def test_a_meta_survives_msgpack_and_json(fps):
    meta = Meta("anna", Skeleton(("a", "b"), (-1, 0), 1), fps)
    for codec in (msgspec.msgpack, msgspec.json):
        assert meta_of_map(codec.decode(codec.encode(map_of_meta(meta)), type=MetaMap)) == meta


def test_frames_survive_msgpack_bit_by_bit():
    positions = np.random.default_rng(1).normal(size=(3, 4, 3)).astype(np.float32)
    positions[0, 1] = np.nan
    frames = Frames(positions, np.arange(3.0), np.full((3, 4), 0.5, np.float32), "anna")
    for i, found in enumerate(maps_of_frames(frames, 7)):
        again = msgspec.msgpack.decode(msgspec.msgpack.encode(found), type=FrameMap)
        assert (again.seq, again.t, again.performer, again.v, again.type) == (
            7 + i,
            float(i),
            "anna",
            1,
            "frame",
        )
        np.testing.assert_array_equal(positions_of_map(again), positions[i])
        np.testing.assert_array_equal(confidence_of_map(again, 4), [0.5] * 4)


def test_json_has_nested_lists_and_null():
    found = msgspec.json.decode(b'{"type":"frame","xyz":[[1,2,3],null,[4,null,6]]}', type=FrameMap)
    positions = positions_of_map(found)
    np.testing.assert_array_equal(positions[0], [1, 2, 3])
    assert np.isnan(positions[1]).all()
    assert np.isnan(positions[2, 1])
    assert confidence_of_map(found, 3) is None


@pytest.mark.parametrize(
    "found",
    [
        FrameMap(xyz=b""),
        FrameMap(xyz=b"123"),
        FrameMap(xyz=bytes(12 * 2000)),
        FrameMap(xyz=bytes(12), shape=(2, 3)),
        FrameMap(xyz=[[1.0, 2.0]]),
    ],
)
def test_positions_of_the_wrong_shape_are_refused(found):
    with pytest.raises(FrameError, match="xyz"):
        positions_of_map(found)


def test_performer_names_are_cleaned():
    assert meta_of_map(MetaMap(("a",), performer="a/b.c d")).performer == "a_b_c_d"
