"""The exact path sum against brute force, and its block methods against one another."""

from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from checks.reference import path_kernel as path_reference
from mossar_stream.core.kernels import (
    FRONTIER_SLOTS,
    MOST_EDGES,
    blocks_depth_first_sum,
    blocks_elimination_order,
    blocks_frontier_sum,
    blocks_groups_of_twins,
    blocks_subset_sum,
    blocks_sum,
    sum_of_paths,
)

WEIGHT = st.one_of(st.just(0.0), st.floats(1e-3, 2.0))


class Block(NamedTuple):
    near: np.ndarray
    link: np.ndarray
    inner: np.ndarray
    ends: np.ndarray


def complete(n):
    return list(combinations(range(n), 2))


def cycle(n):
    return [(v, (v + 1) % n) for v in range(n)]


def ladder(rungs):
    rails = [(v, v + 2) for v in range(2 * rungs - 2)]
    return rails + [(2 * k, 2 * k + 1) for k in range(rungs)]


def random_edges(rng, vertices, edges):
    pairs = complete(vertices)
    return [pairs[k] for k in rng.permutation(len(pairs))[:edges]]


def random_tree(rng, vertices):
    return [(int(rng.integers(v)), v) for v in range(1, vertices)]


def as_array(edges):
    return np.array(edges, np.int64).reshape(-1, 2)


def weights(rng, vertices, edges):
    return rng.uniform(0.1, 1.2, vertices), rng.uniform(0.1, 1.2, len(edges))


def whole_block(rng, vertices, edges):
    on_vertices, on_edges = weights(rng, vertices, edges)
    near, link = np.zeros(vertices, np.int64), np.zeros((vertices, vertices))
    for (u, v), weight in zip(edges, on_edges, strict=True):
        near[u] |= 1 << v
        near[v] |= 1 << u
        link[u, v] = link[v, u] = weight
    return Block(near, link, on_vertices, on_vertices * rng.uniform(1.0, 3.0, vertices))


def frontier_in_any_order(near, link, inner, ends):
    return blocks_frontier_sum(near, link, inner, ends, np.random.default_rng(0).permutation(len(near)))


def check_by_brute_force(vertex_weights, edges, edge_weights):
    expected = path_reference.path_sum(vertex_weights.tolist(), edges, edge_weights.tolist())
    assert sum_of_paths(vertex_weights, as_array(edges), edge_weights) == pytest.approx(expected, rel=1e-12)


@st.composite
def graphs(draw):
    vertices = draw(st.integers(1, 8))
    pairs = [
        pair if draw(st.booleans()) else pair[::-1] for pair in draw(st.permutations(complete(vertices)))
    ]
    edges = pairs[: draw(st.integers(0, min(len(pairs), 14)))]
    vertex_weights = draw(st.lists(WEIGHT, min_size=vertices, max_size=vertices))
    edge_weights = draw(st.lists(WEIGHT, min_size=len(edges), max_size=len(edges)))
    return np.array(vertex_weights), edges, np.array(edge_weights, np.float64)


@settings(deadline=None, max_examples=200)
@given(graphs())
def test_equals_brute_force_on_any_small_graph(graph):
    check_by_brute_force(*graph)


@pytest.mark.parametrize("seed", range(60))
def test_equals_brute_force_on_sparse_graphs_of_many_blocks(seed):
    rng = np.random.default_rng(seed)
    vertices = int(rng.integers(9, 41))
    edges = random_edges(rng, vertices, int(rng.integers(1, vertices + 3)))
    vertex_weights, edge_weights = weights(rng, vertices, edges)
    check_by_brute_force(vertex_weights, edges, edge_weights)


@pytest.mark.parametrize("vertices", [2, 3, 17, 46, 64])
def test_equals_brute_force_on_trees(vertices):
    rng = np.random.default_rng(vertices)
    edges = random_tree(rng, vertices)
    check_by_brute_force(*with_edges(weights(rng, vertices, edges), edges))


@pytest.mark.parametrize("vertices", [3, 4, 5, 6, 12, 13, 16, 17, 40, 63, 64])
def test_equals_brute_force_on_cycles(vertices):
    rng = np.random.default_rng(vertices)
    edges = cycle(vertices)
    check_by_brute_force(*with_edges(weights(rng, vertices, edges), edges))


@pytest.mark.parametrize("vertices", [4, 5, 6, 7, 8])
def test_equals_brute_force_on_complete_graphs(vertices):
    rng = np.random.default_rng(vertices)
    edges = complete(vertices)
    check_by_brute_force(*with_edges(weights(rng, vertices, edges), edges))


def with_edges(both, edges):
    return both[0], edges, both[1]


@pytest.mark.parametrize("vertices", range(2, 11))
def test_counts_the_paths_of_complete_graphs(vertices):
    # Section 2.2.2 of the paper: [e (V - 2)!] paths between any two of V >= 3 vertices, V of length zero.
    between = sum(np.prod(np.arange(vertices - 1 - k, vertices - 1)) for k in range(vertices - 1))
    expected = vertices * (vertices - 1) // 2 * between + vertices
    edges = as_array(complete(vertices))
    assert sum_of_paths(np.ones(vertices), edges, np.ones(len(edges))) == expected


def test_two_complete_graphs_sharing_a_vertex():
    rng = np.random.default_rng(3)
    edges = complete(5) + [(u + 4, v + 4) for u, v in complete(5)] + [(8, 9), (9, 10)]
    check_by_brute_force(*with_edges(weights(rng, 11, edges), edges))


@pytest.mark.parametrize(
    "method", [blocks_depth_first_sum, blocks_subset_sum, frontier_in_any_order, blocks_sum]
)
@pytest.mark.parametrize("seed", range(12))
def test_each_block_method_equals_brute_force(method, seed):
    rng = np.random.default_rng(seed)
    vertices = int(rng.integers(3, 9))
    edges = cycle(vertices)
    edges += [(u, v) for u, v in complete(vertices) if 1 < v - u < vertices - 1 and rng.random() < 0.5]
    block = whole_block(rng, vertices, edges)
    total, down = method(*block)
    assert total == pytest.approx(brute_block_sum(block, edges, block.ends), rel=1e-12)
    without_parent = block.ends.copy()
    without_parent[0] = 0.0
    rest = brute_block_sum(block, edges, without_parent)
    assert rest + block.ends[0] * down == pytest.approx(total, rel=1e-12)


def brute_block_sum(block, edges, ends):
    total = 0.0
    for path in path_reference.simple_paths(len(ends), edges):
        if len(path) > 1:
            on_edges = np.prod([block.link[step] for step in pairwise(path)])
            total += ends[path[0]] * ends[path[-1]] * on_edges * np.prod(block.inner[list(path[1:-1])])
    return float(total)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("edge_count", [30, 45])
def test_methods_agree_on_dense_graphs_of_twelve_vertices(seed, edge_count):
    rng = np.random.default_rng(seed)
    block = whole_block(rng, 12, random_edges(rng, 12, edge_count))
    expected = blocks_depth_first_sum(*block)
    assert blocks_subset_sum(*block) == pytest.approx(expected, rel=1e-11)
    assert frontier_in_any_order(*block) == pytest.approx(expected, rel=1e-11)
    assert blocks_sum(*block) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(
    ("vertices", "edges"), [(18, ladder(9)), (24, ladder(12)), (20, [*cycle(20), (0, 10)])]
)
def test_frontier_equals_depth_first_on_large_blocks(vertices, edges):
    block = whole_block(np.random.default_rng(vertices), vertices, edges)
    assert blocks_sum(*block) == pytest.approx(blocks_depth_first_sum(*block), rel=1e-11)
    order = np.random.default_rng(1).permutation(vertices)
    if vertices == 18:  # a bad order may cost time, never exactness
        assert blocks_frontier_sum(*block, order) == pytest.approx(blocks_depth_first_sum(*block), rel=1e-11)


@pytest.mark.parametrize("seed", range(60))
def test_frontier_equals_subsets_on_random_graphs_of_45_edges(seed):
    rng = np.random.default_rng(seed)
    vertices = 13 + seed % 4
    block = whole_block(rng, vertices, [*cycle(vertices), *extra_edges(rng, vertices, 45 - vertices)])
    order = np.empty(vertices, np.int64)
    assert elimination_width(block, order) <= FRONTIER_SLOTS
    assert blocks_frontier_sum(*block, order) == pytest.approx(blocks_subset_sum(*block), rel=1e-11)


def extra_edges(rng, vertices, count):
    chords = [(u, v) for u, v in complete(vertices) if 1 < v - u < vertices - 1]
    return [chords[k] for k in rng.permutation(len(chords))[:count]]


def elimination_width(block, order):
    return blocks_elimination_order(block.near, order)[1]


@pytest.mark.parametrize("seed", range(30))
def test_the_numbering_of_vertices_and_edges_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    edges = random_edges(rng, 20, 40)
    vertex_weights, edge_weights = weights(rng, 20, edges)
    name, turn = rng.permutation(20), rng.permutation(40)
    renamed = np.empty(20)
    renamed[name] = vertex_weights
    again = sum_of_paths(
        renamed, np.ascontiguousarray(name[as_array(edges)][turn][:, ::-1]), edge_weights[turn]
    )
    assert again == pytest.approx(sum_of_paths(vertex_weights, as_array(edges), edge_weights), rel=1e-11)


def test_no_edges_leave_the_vertices():
    assert sum_of_paths(np.array([0.5, 2.0, 0.0]), as_array([]), np.empty(0)) == 2.5


def test_single_vertex():
    assert sum_of_paths(np.array([0.25]), as_array([]), np.empty(0)) == 0.25


def test_no_vertices():
    assert sum_of_paths(np.empty(0), as_array([]), np.empty(0)) == 0.0


def test_zero_weights_remove_their_edge_or_vertex():
    rng = np.random.default_rng(5)
    edges = complete(6)
    vertex_weights, edge_weights = weights(rng, 6, edges)
    vertex_weights[2] = 0.0
    edge_weights[[0, 7]] = 0.0
    check_by_brute_force(vertex_weights, edges, edge_weights)


def test_arguments_are_left_alone():
    rng = np.random.default_rng(6)
    edges = as_array(random_edges(rng, 12, 20))
    vertex_weights, edge_weights = rng.random(12), rng.random(20)
    kept = edges.copy(), vertex_weights.copy(), edge_weights.copy()
    sum_of_paths(vertex_weights, edges, edge_weights)
    for before, after in zip(kept, (edges, vertex_weights, edge_weights), strict=True):
        np.testing.assert_array_equal(before, after)


def test_nan_is_not_hidden():
    edges = as_array(cycle(4))
    assert np.isnan(sum_of_paths(np.ones(4), edges, np.array([1.0, np.nan, 1.0, 1.0])))
    assert np.isnan(sum_of_paths(np.array([1.0, np.nan, 1.0, 1.0]), edges, np.ones(4)))


def test_more_edges_than_a_set_of_bits_can_hold_are_refused():
    count = MOST_EDGES + 1
    with pytest.raises(ValueError, match="64"):
        sum_of_paths(np.ones(count), as_array(cycle(count)), np.ones(count))


def test_any_number_of_vertices_is_summed():
    rng = np.random.default_rng(7)
    edges = [(150 + u, 150 + v) for u, v in random_edges(rng, 12, 12)]
    check_by_brute_force(*with_edges(weights(rng, 200, edges), edges))


@pytest.mark.parametrize("seed", range(40))
def test_vertices_that_can_be_swapped_are_summed_together(seed):
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 4, 3)
    group = np.repeat(np.arange(len(sizes)), sizes)
    joined = np.triu(rng.random((len(sizes),) * 2) < 0.7)
    vertices = len(group)
    edges = [(u, v) for u, v in complete(vertices) if joined[group[u], group[v]]]
    of_group, between = rng.uniform(0.1, 1.2, len(sizes)), rng.uniform(0.1, 1.2, (len(sizes),) * 2)
    edge_weights = np.array([between[group[u], group[v]] for u, v in edges])
    check_by_brute_force(of_group[group], edges, edge_weights)


def test_twins_are_found_whether_an_edge_joins_them_or_not():
    near = np.array([0b011110, 0b000101, 0b000011, 0b000001 | 0b100000, 0b000001 | 0b100000, 0b011000])
    link = np.array([[near[u] >> v & 1 for v in range(6)] for u in range(6)], np.float64)
    assert blocks_groups_of_twins(near, link, np.ones(6), np.ones(6)) == 4
    assert blocks_groups_of_twins(near, link, np.ones(6), np.arange(6.0)) == 6
    link[3, 5] = link[5, 3] = 0.5
    assert blocks_groups_of_twins(near, link, np.ones(6), np.ones(6)) == 5
