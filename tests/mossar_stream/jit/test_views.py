"""Parts are what slices, views and shapes would be, and those of a row stay within it."""

import numpy as np
import pytest

from mossar_stream import Segmenter, Settings
from mossar_stream.core.row import CACHE_LINE, new_memory
from mossar_stream.core.buffers import Buffers
from mossar_stream.engine.layout import TOOLS, TOOLS_BYTES
from mossar_stream.core.plan import Plan, new_scratch
from mossar_stream.core.pool import Pool
from mossar_stream.jit.decorators import entry_point
from mossar_stream.jit.views import at_address, part

UNTOUCHED = 0xA5


@entry_point
def look(memory, begin, lines, columns):
    numbers = part(memory, begin, np.int16, (lines, 3, columns))
    numbers[lines - 1, 2, columns - 1] = -7
    return numbers.shape, numbers.strides, numbers.sum()


def test_a_part_is_a_view_of_the_same_bytes():
    memory = np.arange(400).astype(np.uint8)
    other = memory.copy()
    view = other[64 : 64 + 2 * 4 * 3 * 8].view(np.int16).reshape(4, 3, 8)
    view[3, 2, 7] = -7
    assert look(memory, 64, 4, 8) == (view.shape, view.strides, view.sum())
    assert (memory == other).all()


@entry_point
def look_at(address, lines, columns):
    numbers = at_address(address, np.int16, (lines, 3, columns))
    numbers[lines - 1, 2, columns - 1] = -7
    return numbers.shape, numbers.strides, numbers.sum()


def test_what_lies_at_an_address_is_a_view_of_the_same_bytes():
    memory = np.arange(400).astype(np.uint8)
    other = memory.copy()
    assert look_at(memory.ctypes.data + 64, 4, 8) == look(other, 64, 4, 8)
    assert (memory == other).all()


def guarded(size):
    """Return bytes, zero, between two lines that must stay as they are, and those lines."""
    memory = new_memory(1, size + 2 * CACHE_LINE)[0]
    ends = memory[:CACHE_LINE], memory[-CACHE_LINE:]
    for end in ends:
        end[:] = UNTOUCHED
    return memory[CACHE_LINE:-CACHE_LINE], ends


@pytest.mark.parametrize(
    "chosen",
    [
        {},
        {"level": "cluster", "smoothing": "one_euro", "remerge_window": 1},
        {"smoothing": "moving_average", "smoothing_window": 5, "remerge_seconds": 0.3},
    ],
    ids=str,
)
@pytest.mark.parametrize("joints", [1, 8, 33])
def test_nothing_is_written_outside_the_row_and_the_scratch(core, joints, chosen):
    plan = Plan(core.skeleton(joints), Settings(range_floor=0.01, window=0.05, **chosen), 60.0)
    buffers, loose = Buffers(), Buffers()
    loose.make_room(plan)
    tools, tools_ends = guarded(len(loose.tools))
    tools[:] = loose.tools  # where the parts begin
    row, row_ends = guarded(plan.row_bytes)
    buffers.make_room(plan)
    buffers.tools, scratch = tools, len(new_scratch(plan.shape))
    own = tools[:TOOLS_BYTES].view(TOOLS)[0]
    begin, at = int(own["scratch"]), int(own["events"])
    beyond = tools[begin + scratch : int(own["store"])]
    beyond[:] = UNTOUCHED
    buffers.scratch, buffers.events = tools[begin : begin + scratch], tools[at : at + len(loose.events)]
    buffers._view = memoryview(buffers.events)
    segmenter = Segmenter.of_row(Pool(plan, buffers, row.reshape(1, -1)).allocate("p1"))
    positions, times = core.moving_people(joints, frames=600, joints=joints)
    events = segmenter.push(positions, times) + segmenter.end_take()
    decided = [e for e in events if e.__struct_config__.tag == "key_frame" and e.decided]
    assert len(decided) > (5 if joints > 1 else -1)  # the centre alone does not move
    for untouched in (*row_ends, *tools_ends, beyond):
        assert (untouched == UNTOUCHED).all()
