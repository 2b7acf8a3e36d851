"""The functions of the compiled core for Python; the files face.pxi describe them, testing.pxi those for tests."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.plan import Plan
from mossar_stream.events import Event
from mossar_stream.moves.explaining import Explanation

Array: TypeAlias = NDArray[Any]  # C-contiguous, of the type that the docstring names
# Offset in bytes, name of the record or number type, shape.
Place: TypeAlias = tuple[int, str, tuple[int, ...]]

BUILT_FROM: str
RECORDS: dict[str, np.dtype[np.void]]  # by the names of the structs
CONSTANTS: dict[str, Any]  # those that follow
ANALYSIS_INTERVAL: float
AT_REST: float
AVERAGED: float
BIN_RATE: float
BOUTS: int
CAP: float
CERTAIN: float
CHAINS: int
COINCIDENT: float
CYCLES: int
DECIDE: int
DURATION: int
EARLIER: float
EARLIER_IN_NOISE: float
FEATURES: int
FRAMES: int
FRONTIER_SLOTS: int
LABELLED_LATE: float
LATEST: float
LAYERS: int
LEAD_COUNTED: float
LEAD_WORTH: float
LEAST_WAY: float
LEAST_WAY_OF_ANKLES: float
LINES: int
LIVE: int
LONGEST_SILENCE: float
MARGIN: float
MOST: float
MOST_CHANGE: float
MOST_EDGES: int
MOST_PHASES: int
MOST_PROMINENT: float
MOVING_FRAMES: int
NOTED_CANDIDATES: int
NOTED_LATE: int
NOT_KEPT: int
ONSET: float
PADDING: int
PAGE: int
PAGE_SIZE: int
PATH: int
PEAK_ABOVE_NOISE: float
PERIOD: float
POSE_FLOOR: float
POSE_UNCHANGED: int
POSE_X: int
PRECISION: float
RANK: int
SHORTEST_SEGMENT: float
SMOOTHED: float
SPACING: float
SPEED_FLOOR: float
SPEED_FLOOR_OF_ODDS: float
SPEED_WINDOW: float
STEP_BEFORE: int
STILL: float
STRICT_WORTH: float
TERM: int
TIME_ROUNDING: float
WEIGHTS: tuple[float, ...]
TESTED_CONSTANTS: dict[str, Any]  # those that follow
ANALYSIS_DUE: int
BEGINNING: float
BINS: int
CACHE_LINE: int
DEVIATIONS: float
DOUBLING: float
DOUBT: float
DWELL_GAP: float
ENDS: int
HAND: float
HAPPENED: int
INTERVAL: float
LATE_DWELL: float
LEAST_EXTENT: float
LEAST_OWN_TIME: float
LEAST_STEADY: float
LEAST_USUAL_SPEED: float
LINGERS_LITTLE: float
LINGERS_OFTEN: float
LONGEST_IN_OWN_TIME: float
LONGEST_PERIOD: float
LONGEST_RATIO: float
MEAN_TIME: float
MEAN_X: int
MEMORY: float
MORE_ROOM: int
MOST_OWN_TIME: float
MOST_RAISED: float
NEAREST_END: float
NEAR_DWELL: float
NO_DWELL: int
OFF_BOUND: float
ORDINARY: float
PER_QUANTUM: float
PRIOR_DWELT: float
PRIOR_EXTENT: float
PRIOR_LINGERED: float
PRIOR_SPEED: float
QUICK: float
QUICKEST: float
REPORTED_ABOVE_NOISE: float
REST_GROWS: float
REST_GROWS_FROM: float
REST_POSE_HALF_LIFE: float
REST_X: int
RISEN: float
SCALES_HALF_LIFE: float
SHORTEST_REST: float
SHORT_INTERVAL: float
SLOW: float
SLOWEST: float
SMOOTHING: float
SPEED_OFFSET: float
SPEED_SETTLING: float
SPLITTING: int
STEADY_SLOWEST: float
STEP: int
TURNED_BACK: float
UNLABELLED: int
VELOCITY_ALONE: int
WAITS_AT_MOST: float
WAITS_FROM: float
WAITS_MORE: float
WITHIN: int
WORK: int
X: int

def has_x86_64_v3() -> bool: ...
def new_row(plan: Array, /) -> NDArray[np.uint8]: ...
def lay_out(memory: Array, plan: Array, /) -> None: ...
def row_bytes(plan: Array, /) -> int: ...
def row_parts(memory: Array, /) -> dict[str, Place]: ...
def placed(positions: Array, center: int, /) -> tuple[NDArray[np.float32], tuple[float, float, float]]: ...
def at_once(performers: Iterable[Performer], steps: Iterable[tuple[Any, ...]], /) -> None: ...
def process_together(performers: list[Performer], positions: Array, times: Array, /) -> None: ...

class Workspace:
    is_busy: bool

class Channel:
    memory: NDArray[np.uint8]
    performer: str
    name: str
    analyses: list[tuple[float, NDArray[np.void]]] | None
    def __init__(self, plan: Plan, performer: str, memory: NDArray[np.uint8]) -> None: ...
    @property
    def plan(self) -> Plan: ...
    @property
    def state(self) -> Any: ...
    @property
    def clock(self) -> Any: ...
    @property
    def is_open(self) -> bool: ...
    @property
    def take(self) -> int: ...
    @property
    def has_begun(self) -> bool: ...
    @property
    def repetitions(self) -> int: ...
    @property
    def phase(self) -> float | None: ...
    @property
    def reported(self) -> tuple[int, dict[int, int], tuple[float, bool]]: ...
    def settle(self, origin: Sequence[float], found: bool, /) -> None: ...
    def carry_on(self, counts: Mapping[str, int], /) -> None: ...
    def adopt_periods(self, periods: Array, /) -> None: ...
    def go_on_from(self, total: int, revisions: dict[int, int], phase: tuple[float, bool], /) -> None: ...

class Performer:
    workspace: Workspace
    channels: tuple[Channel, ...]
    pending: list[Event]
    def __init__(
        self,
        workspace: Workspace,
        channels: tuple[Channel, ...],
        joints: tuple[Sequence[int], ...] = (),
        readers: tuple[Reader, ...] = (),
        phase: bool = False,
    ) -> None: ...
    @property
    def main(self) -> Channel: ...
    def release(self) -> None: ...
    def process(self, positions: Array, times: Array, first_frame: int | None = None, /) -> None: ...
    def process_one(self, positions: object, time: object, /) -> bool: ...
    def end_take(self, reason: str, /) -> None: ...
    def end_take_for(self, reason: str, /) -> None: ...
    def end_limbs(self) -> None: ...
    def end_readers(self) -> None: ...
    def reset(self, reason: str, /) -> None: ...
    def replan(self, i: int, plan: Plan, limbs: tuple[str | None, ...], /) -> None: ...
    def restart(self, i: int, fresh: Channel, /) -> None: ...
    def hand_over(self, others: list[Event], /) -> None: ...
    def set_limbs(self, limbs: tuple[Channel, ...], joints: tuple[Sequence[int], ...], /) -> None: ...
    def set_readers(self, readers: tuple[Reader, ...], phase: bool, /) -> None: ...
    def set_level(self, strengths: tuple[float, ...], /) -> None: ...
    def settle(self) -> None: ...
    def catch_up(self) -> None: ...
    def decide(self, reason: int, /) -> None: ...

class Reader:
    state: NDArray[np.uint8]
    store: NDArray[np.uint8]

class MoveReader(Reader):
    performer: str
    names: tuple[str, ...]
    limbs: tuple[str, ...]
    explained: Callable[[Explanation], object] | None
    def last_word(self) -> list[Event]: ...

class FollowReader(Reader):
    performer: str
    names: tuple[str, ...]
    ends: list[str]
    limbs: dict[str, NDArray[np.int64]]
    extents: list[dict[str, float]]
    boxes: NDArray[np.float32]
    every: float
    def begin(self) -> None: ...
    def counted(self) -> tuple[int, dict[str, int]]: ...
    def decided(self, take: int) -> tuple[list[Event], tuple[int, dict[str, int]]]: ...
    def set_every(self, every: float) -> None: ...
    def now(self, m: int) -> dict[str, Any] | None: ...
    def extent(self, box: Array) -> dict[str, float]: ...

class PoseReader(Reader):
    performer: str
    names: tuple[str, ...]
    ends: list[str]
    limbs: dict[str, NDArray[np.int64]]
    strays: NDArray[np.float64]
    def begin(self) -> None: ...
    def left(self, take: int) -> list[Event]: ...

class StepReader(Reader):
    performer: str

def set_middle(row: Array, middle: Array, /) -> None: ...
def pad(joints: int, /) -> int: ...
def summarise_pieces(
    params: Array,
    poses: Array,
    times: Array,
    starts: Array,
    summaries: Array,
    joints: int,
    /,
) -> None: ...
def summarise_later(params: Array, summaries: Array, size: int, later: Array, /) -> None: ...
def compare(
    params: Array,
    summaries: Array,
    later: Array,
    bounds: tuple[int, int, int],
    scratch: Array,
    found: Array,
    /,
) -> None: ...
def sum_of_paths(vertex_weights: Array, edges: Array, edge_weights: Array, turns: int = 1) -> float: ...
def move_numbers(joints: int, /) -> int: ...
def move_store_bytes(joints: int, examples: int, moves: int, /) -> int: ...
def move_memory_bytes(joints: int, moves: int, /) -> int: ...
def move_store_parts(store: NDArray[np.uint8], /) -> dict[str, Place]: ...
def move_memory_parts(joints: int, moves: int, /) -> dict[str, Place]: ...
def write_example(
    store: NDArray[np.uint8],
    t: int,
    move: int,
    poses: NDArray[np.float32],
    path: NDArray[np.float64],
    /,
) -> None: ...
def compare_with_all(
    store: NDArray[np.uint8],
    poses: NDArray[np.float32],
    path: NDArray[np.float64],
    costs: NDArray[np.float64],
    postures: NDArray[np.float64],
    /,
) -> None: ...
def mean_heading(positions: NDArray[np.float32], girdles: NDArray[np.int64], /) -> tuple[float, float]: ...
def follow_bank_bytes(points: int, bones: int, phases: NDArray[np.int64], /) -> int: ...
def place_follow_examples(store: NDArray[np.uint8], /) -> None: ...
def follow_bank_parts(store: NDArray[np.uint8], /) -> dict[str, Place]: ...
def follow_example_parts(store: NDArray[np.uint8], t: int, /) -> dict[str, Place]: ...
def follow_memory_bytes(store: NDArray[np.uint8], /) -> int: ...
def follow_memory_parts(store: NDArray[np.uint8], /) -> dict[str, Place]: ...
def follow_cell_parts(store: NDArray[np.uint8], t: int, /) -> dict[str, Place]: ...
def pose_bank_bytes(points: int, bones: int, poses: int, /) -> int: ...
def pose_bank_parts(store: NDArray[np.uint8], /) -> dict[str, Place]: ...
def pose_memory_bytes(store: NDArray[np.uint8], /) -> int: ...
def pose_memory_parts(store: NDArray[np.uint8], /) -> dict[str, Place]: ...
def simd_page_sum(page: Array, line: int, /) -> float: ...
def simd_page_product(page: Array, one: int, other: int, /) -> float: ...
def simd_page_within(page: Array, line: int, limit: float, /) -> bool: ...
def simd_line_product(one: Array, other: Array, /) -> float: ...
def simd_line_products(goal: Array, lines: Array, others: Array, count: int, /) -> None: ...
def simd_weighted_sums(goal: Array, weights: Array, lines: Array, count: int, /) -> None: ...
def simd_variance_product(
    sums: Array,
    squares: Array,
    begin: int,
    end: int,
    scale: float,
    floor: float,
    /,
) -> tuple[float, int]: ...
def simd_spread_product(
    sums: Array,
    squares: Array,
    begin: int,
    end: int,
    lines: int,
    stride: int,
    scale: float,
    floor: float,
    /,
) -> float: ...
def simd_lowest_bit(mask: int, /) -> int: ...
def simd_quantise(values: Array, target: Array, scale: float, /) -> None: ...
def label_candidates(
    labels: Array,
    notes: Array,
    periods: Array,
    times: Array,
    speeds: Array,
    found: Array,
    ways: Array | None = None,
    /,
) -> None: ...
def pause_frame(dwells: Array, slow: Array, times: Array, time: float, /) -> int: ...
def tempo_in_force(scales: Array, own_time: bool, /) -> float: ...
def swing_range_of(scores: Array, counts: Array, /) -> float: ...
def split_frames(row: Array, positions: Array, times: Array, until: int, /) -> int: ...
def follow_speeds_alone(row: Array, bouts: Array, speeds: Array, times: Array, /) -> int: ...
def similarity_add_frame(
    params: Array,
    summary: Array,
    body: Array,
    pose: Array,
    joints: int,
    time: float,
    weight: float,
    moving: int,
    speed: float,
    /,
) -> None: ...
def similarity_flush_sums(params: Array, summary: Array, body: Array, padded_joints: int, /) -> None: ...
def similarity_add_pose(
    params: Array,
    summary: Array,
    pose: Array,
    joints: int,
    time: float,
    weight: float,
    /,
) -> None: ...
def similarity_add_joint(params: Array, summary: Array, pose: Array, joints: int, j: int, /) -> None: ...
def similarity_merge_into(params: Array, target: Array, other: Array, /) -> None: ...
def similarity_close(params: Array, summary: Array, /) -> None: ...
def similarity_strength(params: Array, left: Array, right: Array, both: Array, /) -> float: ...
def similarity_merge_cost(params: Array, left: Array, right: Array, both: Array, /) -> float: ...
def similarity_similarity(params: Array, cost: float, left: Array, right: Array, /) -> float: ...
def similarity_write_features(params: Array, summary: Array, features: Any, /) -> None: ...
def blocks_sum(near: Array, link: Array, inner: Array, ends: Array, /) -> tuple[float, float]: ...
def blocks_depth_first_sum(near: Array, link: Array, inner: Array, ends: Array, /) -> tuple[float, float]: ...
def blocks_subset_sum(near: Array, link: Array, inner: Array, ends: Array, /) -> tuple[float, float]: ...
def blocks_groups_of_twins(near: Array, link: Array, inner: Array, ends: Array, /) -> int: ...
def blocks_frontier_sum(
    near: Array,
    link: Array,
    inner: Array,
    ends: Array,
    order: Array,
    /,
) -> tuple[float, float]: ...
def blocks_elimination_order(near: Array, order: Array, /) -> tuple[float, int]: ...
def similarity_remerge(
    params: Array,
    segments: Array,
    bounds: Array,
    costs: Array,
    strengths: Array,
    removed: Array,
    /,
) -> None: ...
def facing(joints: NDArray[np.float32], girdles: NDArray[np.int64], /) -> tuple[float, float]: ...
def smoothed_facing(
    held: NDArray[np.float64],
    found: NDArray[np.float64],
    times: NDArray[np.float64],
    /,
) -> None: ...
def brought_back(x: float, z: float, facing_x: float, facing_z: float, /) -> tuple[float, float]: ...
def step_body(performer: Performer, positions: Array, times: Array, /) -> tuple[int, int]: ...
def step_events(performer: Performer, /) -> None: ...
def hand_out_events(performer: Performer, /) -> None: ...
def analyse_body(performer: Performer, time: float, /) -> None: ...
