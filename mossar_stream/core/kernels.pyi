"""What the compiled core offers to Python; the files named face.pxi say what it does, those named testing.pxi what tests call."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]  # C-contiguous, of the type that the docstring names
Place: TypeAlias = tuple[
    int, str, tuple[int, ...]
]  # offset in bytes, name of the record or number type, shape

BUILT_FROM: str
RECORDS: dict[str, np.dtype[np.void]]  # by the names of the structs
CONSTANTS: dict[str, Any]  # those that follow
ALL_ANALYSES: int
ANALYSED: int
ANALYSIS_INTERVAL: float
AT_REST: float
AVERAGED: float
BIN_RATE: float
BOUTS: int
CACHE_LINE: int
CAP: float
CERTAIN: float
CHAINS: int
CHANGES: int
COINCIDENT: float
CONFIRMED: int
CYCLES: int
DECIDE: int
DONE: int
DURATION: int
EARLIER: float
EARLIER_IN_NOISE: float
END: int
EXPLAINED: int
FARTHEST: float
FEATURES: int
FINAL: int
FRAMES: int
FRONTIER_SLOTS: int
LABELLED_LATE: float
LATEST: float
LAYERS: int
LEAD_COUNTED: float
LEAD_WORTH: float
LEAST_WAY: float
LEAST_WAY_OF_ANKLES: float
LEVEL: int
LINES: int
LIVE: int
LONGEST_SILENCE: float
MARGIN: float
MOST: float
MOST_CHANGE: float
MOST_EDGES: int
MOST_PHASES: int
MOST_PROMINENT: float
MOVE_BEGUN: int
MOVE_DONE: int
MOVE_GOES_ON: int
MOVE_LEFT: int
MOVE_UNCHANGED: int
MOVING_FRAMES: int
NOTED_CANDIDATES: int
NOTED_LATE: int
NOT_KEPT: int
NOT_PLAIN: int
NO_ANALYSIS: int
NO_JOINT: int
NO_NEWS: int
ONSET: float
PADDING: int
PAGE: int
PAGE_SIZE: int
PATH: int
PEAK_ABOVE_NOISE: float
PERIOD: float
PHASE: int
POSE_ENTERED: int
POSE_FLOOR: float
POSE_HELD: int
POSE_LEFT: int
POSE_UNCHANGED: int
POSE_X: int
PRECISION: float
RANK: int
READ: int
RING_FULL: int
SAID: int
SHORTEST_SEGMENT: float
SMOOTHED: float
SPACING: float
SPARE_SUMMARIES: int
SPEED_FLOOR: float
SPEED_FLOOR_OF_ODDS: float
SPEED_WINDOW: float
STAMP_ROUNDING: float
STEP_BEFORE: int
STILL: float
STRICT_WORTH: float
STRIKE: int
TAKE_ENDS: int
TERM: int
TIME_ROUNDING: float
WEIGHTS: tuple[float, ...]
WINDOW_FULL: int
WITHDRAWN: int
TESTED_CONSTANTS: dict[str, Any]  # those that follow
ANALYSIS_DUE: int
BEGINNING: float
BINS: int
DEVIATIONS: float
DOUBLING: float
DOUBT: float
DWELL_GAP: float
ENDS: int
FOLLOW: int
HAND: float
HAPPENED: int
INTERVAL: float
LATE_DWELL: float
LEAST_EXTENT: float
LEAST_OWN_TIME: float
LEAST_USUAL_SPEED: float
LONGEST_IN_OWN_TIME: float
LONGEST_PERIOD: float
LONGEST_RATIO: float
MEAN_TIME: float
MEAN_X: int
MEMORY: float
MOST_OWN_TIME: float
MOST_RAISED: float
NEAREST_END: float
NEAR_DWELL: float
OFF_BOUND: float
ORDINARY: float
PER_QUANTUM: float
PRIOR_DWELT: float
PRIOR_EXTENT: float
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
def run_one(
    desk: Array, tools: Array, measures: Array, positions: object, time: object, buffer: Array, /
) -> int: ...
def run(desk: Array, tools: Array, measures: Array, positions: Array, times: Array, /) -> int: ...
def update_window(row: Array, measure: Array, tools: Array, reason: int, /) -> None: ...
def set_middle(row: Array, middle: Array, /) -> None: ...
def analyse(counting: Array, store: Array, time: float, /) -> bool: ...
def pad(joints: int, /) -> int: ...
def samples_bytes(joints: int, /) -> int: ...
def analysis_bytes(joints: int, /) -> int: ...
def address_of_follow_feet() -> int: ...
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
def address_of_recognise() -> int: ...
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
def address_of_follow_frame() -> int: ...
def follow_bank_bytes(points: int, bones: int, phases: NDArray[np.int64], /) -> int: ...
def place_follow_examples(store: NDArray[np.uint8], /) -> None: ...
def follow_bank_parts(store: NDArray[np.uint8], /) -> dict[str, Place]: ...
def follow_example_parts(store: NDArray[np.uint8], t: int, /) -> dict[str, Place]: ...
def follow_memory_bytes(store: NDArray[np.uint8], /) -> int: ...
def follow_memory_parts(store: NDArray[np.uint8], /) -> dict[str, Place]: ...
def follow_cell_parts(store: NDArray[np.uint8], t: int, /) -> dict[str, Place]: ...
def begin_following(memory: NDArray[np.uint8], store: NDArray[np.uint8], /) -> None: ...
def finish_take(memory: NDArray[np.uint8], store: NDArray[np.uint8], /) -> None: ...
def evaluate(memory: NDArray[np.uint8], store: NDArray[np.uint8], m: int, /) -> None: ...
def address_of_match_frame() -> int: ...
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
def label_candidates(labels: Array, notes: Array, periods: Array, times: Array, found: Array, /) -> None: ...
def swing_range_of(scores: Array, counts: Array, /) -> float: ...
def advance_row(row: Array, measure: Array, positions: Array, times: Array, /) -> tuple[int, int]: ...
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
