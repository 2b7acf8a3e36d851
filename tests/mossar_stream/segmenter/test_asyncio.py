"""Segmenters in programs of asyncio: pushed in executors, cancelled, in several loops at once."""

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_stream import Frames, Performers, Segmenter, Settings, to_json

SETTINGS = Settings(limbs=True, repetitions=True, steps=True)
PIECE = 16


@pytest.fixture(scope="module")
def take():
    shown = performance(3, fps=60.0, seconds=8.0, moves=["rest:1", "squat", "squat"])
    return shown.skeleton, np.array(shown.frames.positions), np.array(shown.frames.times)


@pytest.fixture(scope="module")
def expected(take):
    skeleton, positions, times = take
    segmenter = Segmenter(skeleton, SETTINGS)
    return as_json(segmenter.push(positions, times) + segmenter.end_take())


def as_json(events):
    return [to_json(event) for event in events]


def pieces(take):
    _, positions, times = take
    for begin in range(0, len(times), PIECE):
        yield positions[begin : begin + PIECE], times[begin : begin + PIECE]


async def in_an_executor(take):
    segmenter, loop, found = Segmenter(take[0], SETTINGS), asyncio.get_running_loop(), []
    for piece in pieces(take):
        found += await loop.run_in_executor(None, segmenter.push, *piece)
    return as_json(found + segmenter.end_take())


def test_frames_are_pushed_in_an_executor(take, expected):
    assert asyncio.run(in_an_executor(take)) == expected


def test_several_loops_have_segmenters_of_their_own(take, expected):
    found = []
    loops = [
        threading.Thread(target=lambda: found.append(asyncio.run(in_an_executor(take)))) for _ in range(4)
    ]
    for loop in loops:
        loop.start()
    for loop in loops:
        loop.join()
    assert found == [expected] * 4


def test_tasks_that_push_at_once_are_refused_and_no_frame_is_lost(take):
    segmenter, refused = Segmenter(take[0], SETTINGS), []

    async def one(piece):
        while True:
            try:
                await asyncio.get_running_loop().run_in_executor(None, segmenter.push, *piece)
            except RuntimeError as error:
                refused.append(str(error))
                await asyncio.sleep(0.001)
            else:
                return

    async def all_at_once():
        await asyncio.gather(*(one(piece) for piece in pieces(take)))

    asyncio.run(all_at_once())
    seen = segmenter.stats
    assert seen["frames"] == len(take[2])
    assert all("two threads at once" in text for text in refused)
    segmenter.end_take()


def test_a_cancelled_task_loses_no_event_if_the_push_is_shielded(take, expected):
    segmenter = Segmenter(take[0], SETTINGS)

    async def cancelled_now_and_then():
        loop, found = asyncio.get_running_loop(), []
        with ThreadPoolExecutor(1) as pool:
            for k, piece in enumerate(pieces(take)):
                pushed = loop.run_in_executor(pool, segmenter.push, *piece)
                waiting = asyncio.ensure_future(asyncio.shield(pushed))
                await asyncio.sleep(0)
                if k % 3 == 0:
                    waiting.cancel()
                try:
                    found += await waiting
                except asyncio.CancelledError:
                    found += await pushed
        return found + segmenter.end_take()

    assert as_json(asyncio.run(cancelled_now_and_then())) == expected


def test_tasks_share_a_pool_with_a_lock(take, expected):
    pool, found = Performers(SETTINGS), {name: [] for name in ("ann", "bob", "joe")}

    async def follow(name, lock):
        for positions, times in pieces(take):
            async with lock:
                frames = Frames(positions, times, performer=name)
                events = await asyncio.get_running_loop().run_in_executor(None, pool.push, frames)
            for event in events:
                found[event.performer].append(event)

    async def together():
        lock = asyncio.Lock()
        await asyncio.gather(*(follow(name, lock) for name in found))

    for name in found:
        pool.announce(name, take[0])
    asyncio.run(together())
    for event in pool.end_takes():
        found[event.performer].append(event)
    for name, events in found.items():
        own = [line.replace(f'"{name}'.encode(), b'"p1') for line in as_json(events)]
        assert own == expected
