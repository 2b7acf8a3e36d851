"""Two exact ways to sum the paths of a small biconnected block (see `path_sum`).

A block of n vertices, vertex 0 the one nearest the root, is described by four arrays:

    near   (n,) int64, bit u of near[v] is set where an edge joins u and v
    link   (n, n), weight of that edge, symmetric
    inner  (n,), weight of a vertex that a path runs through
    ends   (n,), weight of a vertex that a path ends at, with all that hangs below it
"""

import numpy as np

from mossar_stream.jit.decorators import kernel
from mossar_stream.jit.simd import lowest_bit


@kernel
def depth_first_sum(near, link, inner, ends):
    """Sum the paths of a block by visiting each of them; result as in `path_sum.block_sum`."""
    n = len(near)
    here = np.empty(n, np.int64)  # vertex at each depth
    ahead = np.empty(n, np.int64)  # neighbours of it not tried yet
    value = np.empty(n)  # weight of the path up to it, its own included
    total = down = 0.0
    for start in range(n):
        reached = 0.0
        here[0], ahead[0], value[0] = start, near[start], 1.0
        on_path = 1 << start
        depth = 0
        while depth >= 0:
            v = here[depth]
            if ahead[depth] == 0:
                on_path ^= 1 << v
                depth -= 1
                continue
            u = lowest_bit(ahead[depth])
            ahead[depth] &= ahead[depth] - 1
            step = value[depth] * link[v, u]
            if u > start:  # else counted from u
                reached += step * ends[u]
            if near[u] & ~on_path != 0:
                depth += 1
                on_path |= 1 << u
                here[depth], ahead[depth], value[depth] = u, near[u] & ~on_path, step * inner[u]
        total += ends[start] * reached
        if start == 0:
            down = reached
    return total, down


@kernel
def find_twins(near, link, inner, ends, twins):
    """Group the vertices that can be swapped without changing a path's weight; vertex 0 stays alone.

    Graphs of skeletons are full of them when all weights are equal, as in the kernel of a segment with itself:
    all joints of a hand move alike.

    Args:
        near: As in the module's docstring, like the next three.
        link: (n, n).
        inner: (n,).
        ends: (n,).
        twins: (4, n), set for each group to: number of members, one member, another one (or the same), and the
            number of states of the groups before.

    Returns:
        Number of groups, and number of states: ways to choose how many members of each group a path covers.
    """
    n = len(near)
    count = 0
    states = 1.0
    for u in range(n):
        group = 1 if u > 0 else count
        while group < count:
            v = twins[1, group]
            same = near[u] & ~(1 << v) == near[v] & ~(1 << u) and inner[u] == inner[v] and ends[u] == ends[v]
            other = 0
            while same and other < n:
                same = link[u, other] == link[v, other] or other == u or other == v  # noqa: PLR1714 - compiles quickly
                other += 1
            if same:
                break
            group += 1
        if group < count:
            twins[2, group] = u
        else:
            group = count
            count += 1
            twins[0, group], twins[1, group], twins[2, group] = 0, u, u
        states *= (twins[0, group] + 2.0) / (twins[0, group] + 1.0)
        twins[0, group] += 1
    stride = 1
    for group in range(count):
        twins[3, group] = stride
        stride *= twins[0, group] + 1 if states < 1e9 else 0
    return count, states


@kernel
def _group_links(link, twins, count):
    """Return the weight of an edge from a group to another or within it, (count, count), and the groups around."""
    step = np.empty((count, count))
    around = np.zeros(count, np.int64)
    for g in range(count):
        for h in range(count):
            step[g, h] = link[twins[1, g], twins[2 if g == h else 1, h]]
            around[g] |= 1 << h if step[g, h] != 0.0 else 0
    return step, around


@kernel
def subset_sum(link, inner, ends, twins, count):
    """Sum the paths of a block by the sets they cover; as in `path_sum.block_sum`.

    A set says how many members of each group of twins are covered. ``sums[S, g]`` is the weight of all paths that
    cover the set S and end in the group g, without the weight of that end. Few sets of a sparse graph are covered
    by any path, so the groups where one ends are kept as bits of ``live[S]``.

    Args:
        link: As in the module's docstring, like the next two.
        inner: (n,).
        ends: (n,).
        twins: (4, n) from `find_twins`.
        count: Number of groups.
    """
    size, member, stride = twins[0], twins[1], twins[3]
    states = stride[count - 1] * (size[count - 1] + 1)
    live = np.zeros(states, np.int64)
    sums = np.empty((states, count))
    step, around_group = _group_links(link, twins, count)
    for g in range(count):
        live[stride[g]] = 1 << g
        sums[stride[g], g] = size[g]
    covered = np.zeros(count, np.int64)  # members of each group in the set
    vacant = (1 << count) - 1  # groups with a member outside
    vertices = 0  # in the set
    total = down = 0.0
    for state in range(1, states):
        g = 0
        while covered[g] == size[g]:  # count up
            vertices -= covered[g]
            covered[g] = 0
            vacant |= 1 << g
            g += 1
        covered[g] += 1
        vertices += 1
        vacant ^= 1 << g if covered[g] == size[g] else 0
        tips = live[state]
        around, rest = 0, tips
        while rest != 0:
            g = lowest_bit(rest)
            rest &= rest - 1
            around |= around_group[g] & vacant
            if vertices == 1:
                sums[state, g] *= ends[member[g]]
            else:
                total += sums[state, g] * ends[member[g]]
                sums[state, g] *= inner[member[g]]
        while around != 0:
            h = lowest_bit(around)
            around &= around - 1
            reached, rest = 0.0, tips & around_group[h]
            while rest != 0:
                g = lowest_bit(rest)
                rest &= rest - 1
                reached += sums[state, g] * step[h, g]
            live[state + stride[h]] |= 1 << h
            sums[state + stride[h], h] = reached * (size[h] - covered[h])
            if h == 0:
                down += reached
    return 0.5 * total, down  # every path was built from both its ends
