"""Snapshots: damaged, foreign and hostile ones are refused; what is accepted can be worked on."""

import copy
import functools
import hashlib
import operator
import pickle
import re
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st

import mossar_stream
from mossar_stream import Segmenter, Settings, SnapshotError
from mossar_stream.core.kernels import MEAN_X, POSE_X, RECORDS, REST_X, X, row_parts
from mossar_stream.core.plan import Plan
from mossar_stream.core.row import ROW, records, region
from mossar_stream.core.snapshot import HEADER_BYTES, MAGIC, SNAPSHOT_VERSION

CORE = Path(mossar_stream.__file__).parent
KINDS = {
    "evidence": {},
    "likelihood": {"level": "posture"},
    "path kernel": {"similarity": "path_kernel", "layers": 2, "edges": 4, "level": "cluster"},
}


@pytest.fixture(scope="module", params=KINDS.values(), ids=KINDS)
def segmenter(core, request):
    """A segmenter with a take that is open and key frames that are undecided."""
    positions, times = core.moving_people(1, frames=200, losses=False)
    own = Segmenter(core.skeleton(4), Settings(range_floor=0.01, window=0.05, **request.param), fps=60.0)
    own.push(positions, times)
    assert own.row.state["window"]["undecided"] > 3
    return own


def sealed(body):
    return MAGIC + bytes([SNAPSHOT_VERSION]) + hashlib.sha256(body).digest() + body


def forged(blob, **changes):
    """Return a snapshot with other contents and the right checksum."""
    content = msgspec.msgpack.decode(blob[HEADER_BYTES:])
    return sealed(msgspec.msgpack.encode({**content, **changes}))


def with_row(segmenter, change):
    """Return a snapshot whose row was changed, with the right checksum."""
    row = segmenter.row.memory.copy()
    change(row)
    return forged(segmenter.snapshot(), row=row.tobytes())


COPIES = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),
}


@pytest.mark.parametrize("way", COPIES)
def test_a_copy_goes_on_by_itself(core, way):
    positions, times = core.moving_people(1, frames=200, losses=False)
    own = Segmenter(core.skeleton(4), Settings(range_floor=0.01, window=0.05, limbs=True), fps=60.0)
    own.push(positions[:120], times[:120])
    own.level = 0.5  # what follows from it waits
    before = own.snapshot()
    other = COPIES[way](own)
    found = core.lines(other.push(positions[120:], times[120:]) + other.end_take())
    assert own.snapshot() == before
    assert core.lines(own.push(positions[120:], times[120:]) + own.end_take()) == found != []


@pytest.mark.parametrize("wrong", [b"", b"x", MAGIC, MAGIC + b"\x01" + bytes(31), b"PK" + bytes(500)])
def test_what_is_no_snapshot_is_refused(wrong):
    with pytest.raises(SnapshotError, match="not a snapshot"):
        Segmenter.restore(wrong)


def test_a_truncated_snapshot_is_refused(segmenter):
    blob = segmenter.snapshot()
    for size in [*range(0, HEADER_BYTES, 7), HEADER_BYTES, len(blob) // 2, len(blob) - 1]:
        with pytest.raises(SnapshotError):
            Segmenter.restore(blob[:size])
    with pytest.raises(SnapshotError):
        Segmenter.restore(blob + b"\x00")


def test_a_damaged_snapshot_is_refused(segmenter):
    blob = segmenter.snapshot()
    for place in np.linspace(0, len(blob) - 1, 200).astype(int):
        damaged = bytearray(blob)
        damaged[place] ^= 0x40
        with pytest.raises(SnapshotError):
            Segmenter.restore(bytes(damaged))


def test_a_newer_snapshot_is_refused_by_its_version(segmenter):
    blob = bytearray(segmenter.snapshot())
    blob[len(MAGIC)] = SNAPSHOT_VERSION + 1
    with pytest.raises(
        SnapshotError, match=f"version {SNAPSHOT_VERSION + 1}; this program reads version {SNAPSHOT_VERSION}"
    ):
        Segmenter.restore(bytes(blob))


def test_a_snapshot_of_an_earlier_version_is_refused_by_its_version(segmenter):
    blob = bytearray(segmenter.snapshot())
    blob[len(MAGIC)] = SNAPSHOT_VERSION - 1
    with pytest.raises(
        SnapshotError, match=f"version {SNAPSHOT_VERSION - 1}; this program reads version {SNAPSHOT_VERSION}"
    ):
        Segmenter.restore(bytes(blob))


def numbers_in(name):
    """Return the whole numbers that a file of the core names."""
    text = (CORE / name).read_text(encoding="utf-8")
    return re.findall(r"^    ([A-Z_]+) = (\S+)", text, re.MULTILINE)


def test_rows_that_are_laid_out_otherwise_have_the_next_version(core):
    # Does this fail? Then raise SNAPSHOT_VERSION unless names alone have changed, and take the new digest down beside it.
    kept = (
        "Row",
        "Key",
        "Mark",
        "Memo",
        "Bout",
        "Note",
        "Counting",
        "Periods",
        "Measure",
        "RecognitionState",
        "FollowingState",
        "FollowedMove",
        "HoldingState",
        "Steps",
    )
    kinds = [RECORDS[name].descr for name in kept]
    lines = [numbers_in(name) for name in ("core/joint_pages.pxi", "similarity/summary.pxi")]
    rows = [row_parts(Plan(core.skeleton(33), Settings(**kind)).new_row()) for kind in KINDS.values()]
    digest = hashlib.sha256(repr((kinds, lines, rows)).encode()).hexdigest()[:16]
    assert (SNAPSHOT_VERSION, digest) == (35, "461e56eb6ffc4da5")


@pytest.mark.parametrize(
    "changes",
    [
        {"row": b""},
        {"row": bytes(64)},
        {"ring": 0},
        {"ring": -5},
        {"ring": 2**62},
        {"room": 0},
        {"room": -5},
        {"fps": -1.0},
        {"fps": float("nan")},
        {"level": "loud"},
        {"level": float("nan")},
        {"level": -1.0},
        {"settings": {"window": 1e9}},
        {"settings": {"range": "file"}},
        {"settings": {"remerge_window": 1024}},
        {"skeleton": {"names": []}},
        {"skeleton": {"names": ["a", "b", "c", "d"], "parents": [1, 0, 0, 0]}},
        {"skeleton": {"names": ["a"] * 4}},
        {"skeleton": 7},
        {"pending": [{"type": "key_frame"}]},
        {"more": 1},
    ],
    ids=str,
)
def test_contents_that_cannot_be_are_refused_in_spite_of_their_checksum(segmenter, changes):
    with pytest.raises(SnapshotError) as refused:
        Segmenter.restore(forged(segmenter.snapshot(), **changes))
    assert "\n" not in str(refused.value)


def test_bytes_that_are_no_map_are_refused():
    for body in (b"", b"\xc0", b"\x93\x01\x02\x03", b"\xff" * 40, msgspec.msgpack.encode({"row": b"x"})):
        with pytest.raises(SnapshotError):
            Segmenter.restore(sealed(body))


INDICES = {
    "velocity.head": [-1, 10**6, 2**62],
    "velocity.filled": [-1, 10**6],
    "average.head": [-1, 1],
    "average.filled": [-1, 1],
    "history.head": [-1, 10**6],
    "history.filled": [-1, 10**6],
    "window.undecided": [-1, 9, 2**40],
    "ways.home": [-1, -(2**40)],
    "labels.candidates": [-1, 2**40],
    "labels.labelled": [-1, 10**9],
    "window.ordinal": [-1, 0],
    "open_segment.settled": [-1, 10**9],
    "open_segment.since": [-1, 99],
    "open_segment.run": [-1, 99],
    "open_segment.fed": [-1, 99],
    "open_segment.closed": [0, 99],
    "slots.unused_count": [-1, 0, 10**9],
    "curve.found.happened": [1, 31],
    "window.left_ordinal": [-2, 10**6],
    "clock.open": [2, -1],
    "window.has_before": [2],
}


@pytest.mark.parametrize("name", INDICES)
def test_an_index_that_points_nowhere_is_refused(segmenter, name):
    for value in INDICES[name]:

        def change(row, value=value):
            *names, field = name.split(".")
            functools.reduce(operator.getitem, names, records(row))[field] = value

        with pytest.raises(SnapshotError, match="contradicts itself"):
            Segmenter.restore(with_row(segmenter, change))


COUNTED = {
    "open": [-1, 2**50],
    "analysed": [-1, 2**40],
    "cycles": [-1, 65],
    "changed": [-2, 65],
    "begun": [0, 2],
    "origin": [np.nan, -1e12],
    "latest": [np.inf, 1e9],
    "due": [np.nan],
    "cycle": [2**60, 2**32 + 50_000, 50_000 - 2**32, -1],  # places in the window are computed in 32 bits
    "fine": [-1, 2**60],
}


@pytest.mark.parametrize("name", COUNTED)
def test_repetitions_that_cannot_be_are_refused(segmenter, name):
    if not len(region(segmenter.row.memory, "counted")):
        pytest.skip("only where evidence decides")
    for value in COUNTED[name]:

        def change(row, value=value):
            header = region(row, "counted")[0]
            if name == "cycle":
                header["cycle"]["end"][0] = value
            else:
                header[name] = value

        with pytest.raises(SnapshotError, match="contradicts itself"):
            Segmenter.restore(with_row(segmenter, change))


@pytest.mark.parametrize("value", [np.nan, np.inf, -3e38])
@pytest.mark.parametrize("step", [1, 5, 1001])
def test_samples_that_are_no_numbers_keep_nothing_from_going_on(segmenter, core, value, step):
    if not len(region(segmenter.row.memory, "counted")):
        pytest.skip("only where evidence decides")
    positions, times = core.moving_people(1, frames=600, losses=False)

    def change(row):
        region(row, "samples").view(np.float32)[::step] = value

    own = Segmenter.restore(with_row(segmenter, change))
    own.push(positions[200:], times[200:])
    own.snapshot()
    assert own.end_take()[-1].event == "ended"


@pytest.mark.parametrize("value", [np.nan, np.inf, 3e38])
@pytest.mark.parametrize("line", [POSE_X, MEAN_X, REST_X, X])
def test_joints_that_are_nowhere_keep_nothing_from_going_on(segmenter, core, value, line):
    """Then no merge of segments has a cost, and the key frames are removed one by one all the same."""
    positions, times = core.moving_people(1, frames=600, losses=False)

    def change(row):
        region(row, "body")[line] = value

    own = Segmenter.restore(with_row(segmenter, change))
    own.push(positions[200:], times[200:])
    own.snapshot()
    assert own.end_take()[-1].event == "ended"


@pytest.mark.parametrize("name", ["order", "unused"])
def test_a_slot_used_twice_or_out_of_range_is_refused(segmenter, name):
    for value in (-1, 10**9, int(segmenter.row.state["open_segment"]["settled"])):

        def change(row, value=value):
            region(row, name)[0] = value

        with pytest.raises(SnapshotError, match="contradicts itself"):
            Segmenter.restore(with_row(segmenter, change))


@pytest.mark.parametrize(
    ("field", "value"), [("before", 10**9), ("before", -7), ("ordinal", 10**9), ("kind", 3), ("kept", 2)]
)
def test_a_key_frame_that_cannot_be_is_refused(segmenter, field, value):
    def change(row):
        region(row, "keys")[field][1] = value

    with pytest.raises(SnapshotError, match="contradicts itself"):
        Segmenter.restore(with_row(segmenter, change))


@examples(max_examples=150)
@given(
    st.lists(st.tuples(st.integers(0, 2**30), st.integers(0, 255)), min_size=1, max_size=40),
    st.integers(0, 2),
)
def test_whatever_is_accepted_can_be_worked_on(core, segmenter, hits, where):
    sizes = [ROW.itemsize, segmenter.row.state["at"]["memo"].item(), len(segmenter.row.memory)]

    def change(row):
        for place, value in hits:
            row[place % sizes[where]] = value

    try:
        restored = Segmenter.restore(with_row(segmenter, change))
    except SnapshotError:
        return
    positions, times = core.moving_people(2, frames=60, losses=False)
    # A hostile time may make the velocity ring grow with every frame: that is bounded by the frames pushed.
    restored.push(positions, times + 3.4)
    restored.level = 0.0
    restored.end_take()
    restored.push(positions, times)


def test_the_parts_that_settings_decide_are_not_taken_from_the_row(segmenter):
    def change(row):
        for name in (
            "joints",
            "padded_joints",
            "slot",
            "slot_count",
            "ring",
            "capacity",
            "room",
            "history_size",
            "memo_size",
        ):
            records(row)["plan"][name] = 10**9
        records(row)["at"]["summaries"] = 10**9

    restored = Segmenter.restore(with_row(segmenter, change))
    assert restored.snapshot() == Segmenter.restore(segmenter.snapshot()).snapshot()


@pytest.mark.parametrize("level", ["motion", "cluster"])
@pytest.mark.parametrize("fps", [None, 30.0, 120.0])
def test_a_snapshot_of_33_joints_takes_at_most_164_kb(core, level, fps):
    # 59 kB of it, at level motion, are the poses of 12 s in which repetitions are counted, and what was counted.
    segmenter = Segmenter(core.skeleton(33), Settings(level=level), fps=fps)
    positions = np.cumsum(np.random.default_rng(0).normal(0, 0.01, (900, 33, 3)), axis=0)
    segmenter.push(positions, np.arange(900) / (fps or 60.0))
    assert len(segmenter.snapshot()) <= 164 * 1024


def test_pending_events_are_kept(core):
    positions, times = core.moving_people(3, frames=200, losses=False)
    own = Segmenter(core.skeleton(4), Settings(range_floor=0.01, window=0.05, remerge_seconds=1e6))
    own.push(positions, times)
    own.level = 1e8
    restored = Segmenter.restore(own.snapshot())
    events = [s.push(positions[-1], times[-1] + 0.01) for s in (own, restored)]
    assert core.lines(events[0]) == core.lines(events[1])
    assert core.key_frames(events[1], "merged")
