"""Two exact ways to sum the paths of a small biconnected block (see `path_sum`).

A block of n vertices, vertex 0 the one nearest the root, is described by four arrays:

    near   (n,) int64, bit u of near[v] is set where an edge joins u and v
    link   (n, n), weight of that edge, symmetric
    inner  (n,), weight of a vertex that a path runs through
    ends   (n,), weight of a vertex that a path ends at, with all that hangs below it
"""


cdef (double, double) depth_first_sum(Ints near, DoubleRows link, Doubles inner, Doubles ends) noexcept nogil:
    """Sum the paths of a block by visiting each of them; result as in `path_sum.block_sum`."""
    cdef int64_t n, start, on_path, depth, v, u
    cdef Ints here, ahead
    cdef Doubles value
    cdef double total, down, reached, step
    # CHECK np.empty: np.empty(n, np.int64)
    # CHECK np.empty: np.empty(n)
    n = near.count
    here = np.empty(n, np.int64)  # vertex at each depth
    ahead = np.empty(n, np.int64)  # neighbours of it not tried yet
    value = np.empty(n)  # weight of the path up to it, its own included
    total = down = 0.0
    for start in range(n):
        reached = 0.0
        here.at[0], ahead.at[0], value.at[0] = start, near.at[start], 1.0
        on_path = <int64_t>1 << start
        depth = 0
        while depth >= 0:
            v = here.at[depth]
            if ahead.at[depth] == 0:
                on_path ^= <int64_t>1 << v
                depth -= 1
                continue
            u = lowest_bit(ahead.at[depth])
            ahead.at[depth] &= ahead.at[depth] - 1
            step = value.at[depth] * link.at[v * link.columns + u]
            if u > start:  # else counted from u
                reached += step * ends.at[u]
            if near.at[u] & ~on_path != 0:
                depth += 1
                on_path |= <int64_t>1 << u
                here.at[depth], ahead.at[depth], value.at[depth] = u, near.at[u] & ~on_path, step * inner.at[u]
        total += ends.at[start] * reached
        if start == 0:
            down = reached
    return total, down


cdef (int64_t, double) find_twins(Ints near, DoubleRows link, Doubles inner, Doubles ends, IntRows twins) noexcept nogil:
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
    cdef int64_t n, count, u, stride, group, v, other
    cdef double states
    cdef bint same
    n = near.count
    count = 0
    states = 1.0
    for u in range(n):
        group = 1 if u > 0 else count
        while group < count:
            v = twins.at[1 * twins.columns + group]
            same = near.at[u] & ~(<int64_t>1 << v) == near.at[v] & ~(<int64_t>1 << u) and inner.at[u] == inner.at[v] and ends.at[u] == ends.at[v]
            other = 0
            while same and other < n:
                same = link.at[u * link.columns + other] == link.at[v * link.columns + other] or other == u or other == v
                other += 1
            if same:
                break
            group += 1
        if group < count:
            twins.at[2 * twins.columns + group] = u
        else:
            group = count
            count += 1
            twins.at[group], twins.at[1 * twins.columns + group], twins.at[2 * twins.columns + group] = 0, u, u
        states *= (twins.at[group] + 2.0) / (twins.at[group] + 1.0)
        twins.at[group] += 1
    stride = 1
    for group in range(count):
        twins.at[3 * twins.columns + group] = stride
        stride *= twins.at[group] + 1 if states < 1e9 else 0
    return count, states


cdef (DoubleRows, Ints) _group_links(DoubleRows link, IntRows twins, int64_t count) noexcept nogil:
    """Return the weight of an edge from a group to another or within it, (count, count), and the groups around."""
    cdef DoubleRows step
    cdef Ints around
    cdef int64_t g, h
    # CHECK np.empty: np.empty((count, count))
    # CHECK np.zeros: np.zeros(count, np.int64)
    step = np.empty((count, count))
    around = np.zeros(count, np.int64)
    for g in range(count):
        for h in range(count):
            step.at[g * step.columns + h] = link.at[twins.at[1 * twins.columns + g] * link.columns + twins.at[(2 if g == h else 1) * twins.columns + h]]
            around.at[g] |= <int64_t>1 << h if step.at[g * step.columns + h] != 0.0 else 0
    return step, around


cdef (double, double) subset_sum(DoubleRows link, Doubles inner, Doubles ends, IntRows twins, int64_t count) noexcept nogil:
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
    cdef int64_t states, g, vacant, vertices, state, tips, around, rest, h
    cdef Ints live, covered, size, member, stride, around_group
    cdef DoubleRows sums, step
    cdef double total, down, reached
    # CHECK np.zeros: np.zeros(states, np.int64)
    # CHECK np.empty: np.empty((states, count))
    # CHECK np.zeros: np.zeros(count, np.int64)
    size = row_of_ints(twins, 0)
    member = row_of_ints(twins, 1)
    stride = row_of_ints(twins, 3)
    states = stride.at[count - 1] * (size.at[count - 1] + 1)
    live = np.zeros(states, np.int64)
    sums = np.empty((states, count))
    step, around_group = _group_links(link, twins, count)
    for g in range(count):
        live.at[stride.at[g]] = <int64_t>1 << g
        sums.at[stride.at[g] * sums.columns + g] = size.at[g]
    covered = np.zeros(count, np.int64)  # members of each group in the set
    vacant = (<int64_t>1 << count) - 1  # groups with a member outside
    vertices = 0  # in the set
    total = down = 0.0
    for state in range(1, states):
        g = 0
        while covered.at[g] == size.at[g]:  # count up
            vertices -= covered.at[g]
            covered.at[g] = 0
            vacant |= <int64_t>1 << g
            g += 1
        covered.at[g] += 1
        vertices += 1
        vacant ^= <int64_t>1 << g if covered.at[g] == size.at[g] else 0
        tips = live.at[state]
        around, rest = 0, tips
        while rest != 0:
            g = lowest_bit(rest)
            rest &= rest - 1
            around |= around_group.at[g] & vacant
            if vertices == 1:
                sums.at[state * sums.columns + g] *= ends.at[member.at[g]]
            else:
                total += sums.at[state * sums.columns + g] * ends.at[member.at[g]]
                sums.at[state * sums.columns + g] *= inner.at[member.at[g]]
        while around != 0:
            h = lowest_bit(around)
            around &= around - 1
            reached, rest = 0.0, tips & around_group.at[h]
            while rest != 0:
                g = lowest_bit(rest)
                rest &= rest - 1
                reached += sums.at[state * sums.columns + g] * step.at[h * step.columns + g]
            live.at[state + stride.at[h]] |= <int64_t>1 << h
            sums.at[(state + stride.at[h]) * sums.columns + h] = reached * (size.at[h] - covered.at[h])
            if h == 0:
                down += reached
    return 0.5 * total, down  # every path was built from both its ends
