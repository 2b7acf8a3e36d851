import tracemalloc

import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.units import height

# What is said about files that are no recordings of a person in space.
REFUSED = {
    "Empty.c3d": "the file is empty",
    "walk01_hierarchy.csv": "no headings with x, y and z of joints",
    "skeleton.asf": "a skeleton without motion; open the .amc",
    "86.asf": "a skeleton without motion; open the .amc",
    **{f"{number:03}.json": "its poses are 2-D" for number in range(40, 50)},
}
NOT_PEOPLE = {"full_precision_frame_time.bvh", "rotation_first_root.bvh"}  # made up for their dialects
NOBODY = {"108_frontraise.npz"}  # the pose estimator found nobody in any picture


def test_every_real_file_reads_with_a_plausible_height_or_is_refused_with_one_line(shared):
    paths = [p for folder in ("formats", "labelled") for p in sorted((shared / folder).rglob("*.*"))]
    assert len(paths) > 80
    for path in paths:
        is_label = path.suffix == ".json" and "labelled" in path.parts
        problem = "this holds no poses; it is about the recording" if is_label else REFUSED.get(path.name)
        if problem is not None:
            with pytest.raises(FileError) as found:
                open_recording(path)
            assert problem in str(found.value)
            assert "\n" not in str(found.value)
            continue
        recording = open_recording(path, ReadOptions(skeleton=asf_for(path, shared)))
        positions = np.concatenate([frames.positions for frames in recording.chunks()])
        assert len(positions) == recording.frame_count > 0
        assert recording.fps is not None
        assert 5 <= recording.fps <= 250
        if path.name not in NOT_PEOPLE | NOBODY:
            assert 0.5 < height(positions) < 2.5, path


def asf_for(path, shared):
    """Return the stand-in skeleton that the labels of a recording name."""
    return str(shared / "labelled" / "86.asf") if path.parent == shared / "labelled" else None


@pytest.mark.parametrize(
    "kind", ["bvh", "amc", "csv", "trc", "jsonl", "msk", "qtm", "motive", "npz", "c3d", "ntu", "osc"]
)
def test_memory_stays_flat_however_long_the_recording(sample, kind):
    path = sample(kind)
    peaks = []
    for times in (10, 40):
        lengthen(path, kind, times)
        tracemalloc.start()
        count = sum(len(frames) for frames in open_recording(path).chunks())
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert count >= 29 * times
        sample(kind)
    assert peaks[1] < 2 * peaks[0] + (1 << 20)


def lengthen(path, kind, times):
    """Repeat the frames of a small recording."""
    if kind == "npz":
        with np.load(path) as arrays:
            np.savez(path, positions=np.tile(arrays["positions"], (times, 1, 1)), fps=60.0)
        return
    data = path.read_bytes()
    frames = {
        "bvh": 30,
        "csv": 30,
        "trc": 30,
        "jsonl": 30,
        "qtm": 30,
        "motive": 30,
        "amc": 90,
        "ntu": 840,
        "osc": 120,
    }
    if kind in frames:
        lines = data.splitlines(keepends=True)
        head, body = lines[: -frames[kind]], lines[-frames[kind] :]
        data = b"".join(head).replace(b"Frames: 30", b"Frames: 99999") + b"".join(body) * times
        data = data if kind != "ntu" else str(30 * times).encode() + data[2:]
    elif kind == "msk":
        records, at = [], 4
        while at < len(data):
            end = at + 4 + int.from_bytes(data[at : at + 4], "little")
            records.append(data[at:end])
            at = end
        data = data[:4] + records[0] + b"".join(records[1:]) * times
    else:
        last = (30 * times).to_bytes(2, "little")
        data = data[:8] + last + data[10:1536] + data[1536:] * times
    path.write_bytes(data)
