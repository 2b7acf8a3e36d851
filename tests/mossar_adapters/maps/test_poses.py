import json

import numpy as np
import pytest

from mossar_adapters.files import ReadOptions, read
from mossar_adapters.maps.lines import LineDecoder
from mossar_adapters.source import Meta
from mossar_stream import Frames

NAMES = ("hips", "neck", "head", "left_hand")
COUNT = 40


def pose(k):
    return [[0.0, 1.0, 0.01 * k], [0.0, 1.5, 0.0], [0.0, 1.7, 0.0], [0.3, 1.0 + 0.02 * k, 0.1]]


def lines(shape, unit=1.0):
    for k in range(COUNT):
        points = pose(k)
        if shape == "names":
            frame = {"joints": dict(zip(NAMES, points, strict=True))}
        elif shape == "points":
            frame = {
                "landmarks": [
                    {"name": n, "x": x, "y": y, "z": z} for n, (x, y, z) in zip(NAMES, points, strict=True)
                ]
            }
        else:
            frame = {"people": [{"joints": dict(zip(NAMES, points, strict=True))}] * 2}
        yield json.dumps({"t": k / 30 * unit, **frame})


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e9])
@pytest.mark.parametrize("shape", ["names", "points", "people"])
def test_poses_on_standard_input_are_those_of_a_file(tmp_path, shape, unit):
    path = tmp_path / "take.jsonl"
    path.write_text("\n".join(lines(shape, unit)) + "\n")
    take = read(path)
    decoder = LineDecoder()
    items = decoder.receive(path.read_bytes(), 0.0) + decoder.end(0.1)
    metas = [item for item in items if isinstance(item, Meta)]
    assert [meta.performer for meta in metas] == ["p1", "p2"][: len(metas)]
    assert len(metas) == (2 if shape == "people" else 1)
    assert metas[0].skeleton == take.skeleton
    frames = [item for item in items if isinstance(item, Frames) and item.performer == "p1"]
    positions = np.concatenate([item.positions for item in frames])
    times = np.concatenate([item.times for item in frames])
    assert times - times[0] == pytest.approx(take.times - take.times[0], abs=1e-6)
    ratio = np.ptp(positions[:, :, 1]) / np.ptp(take.positions[:, :, 1])
    assert positions / ratio == pytest.approx(take.positions, abs=1e-5), "the file's height is a median"
    assert ratio == pytest.approx(1.0, abs=0.3)
    assert decoder.usable == COUNT * len(metas)
    assert decoder.counters.malformed == 0


def test_flat_poses_are_refused_with_the_reason_unless_they_are_allowed():
    line = b'{"joints": {"a": [0, 1], "b": [0, 2], "c": [1, 2]}}\n'
    decoder = LineDecoder()
    assert decoder.receive(line, 0.0) == []
    assert "2-D" in decoder.counters.last_error
    allowed = LineDecoder(ReadOptions(allow_2d=True))
    assert len(allowed.receive(line, 0.0)) == 2


@pytest.mark.parametrize("line", [b'{"hello": 1}', b"[1, 2]", b'{"type": "key_frame", "joints": {}}', b"3"])
def test_other_objects_are_ignored_as_before(line):
    decoder = LineDecoder()
    assert decoder.receive(line + b"\n", 0.0) == []
    assert decoder.usable == 0


@pytest.mark.parametrize(
    "line",
    [b'{"t": 0.5, "\xd2": 1}', b'{"t": 0.5, "joints": {"\xff\xfe": [0, 1, 0]}}', b'{"a": ' + b"[" * 9999],
)
def test_lines_that_are_no_json_are_counted_and_what_follows_is_read(line):
    decoder = LineDecoder(ReadOptions())
    good = b'{"t": 0.5, "joints": {"hips": [0, 1, 0], "neck": [0, 1.5, 0], "head": [0, 1.7, 0]}}'
    items = [*decoder.receive(line + b"\n" + good + b"\n", 0.0), *decoder.end(1.0)]
    assert decoder.counters.malformed == 1
    assert any(isinstance(item, Frames) for item in items)
