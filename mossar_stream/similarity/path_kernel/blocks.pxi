"""Two exact ways to sum the paths of a small biconnected block (see `path_sum.pxi`)."""

cdef enum:
    MOST_VERTICES = MOST_EDGES  # of a block
    MOST_GROUPS = 17  # of twins, where a block is summed by subsets: `MOST_STATES` is 2 to this power


cdef struct Block:  # Vertex 0 is the one nearest the root.
    int64_t count  # n, of vertices
    uint64_t near[MOST_VERTICES]  # (n,) bit u of near[v] is set where an edge joins u and v
    double link[MOST_VERTICES * MOST_VERTICES]  # (n, n) weight of that edge, symmetric; 0 where there is none
    double inner[MOST_VERTICES]  # (n,) weight of a vertex that a path runs through
    double ends[MOST_VERTICES]  # (n,) weight of a vertex that a path ends at, with all that hangs below it


cdef struct BlockSum:
    double total  # of the weights of the block's paths of length >= 1
    double down  # the part of it that ends at vertex 0, over ends[0]


cdef struct Twins:  # Groups of vertices that can be swapped without changing a path's weight; vertex 0 stays alone.
    int64_t count  # of groups
    double states  # choices of the numbers of members of each group that a path covers
    int64_t size[MOST_VERTICES]  # (count,) number of members of each group
    int64_t member[MOST_VERTICES]  # (count,) one of them
    int64_t other[MOST_VERTICES]  # (count,) another one, or the same
    int64_t stride[MOST_VERTICES]  # (count,) number of states of the groups before; 0 where it is beyond use


cdef inline uint64_t bit(int64_t v) noexcept nogil:
    """Return the set of one vertex."""
    return <uint64_t>1 << v


cdef BlockSum depth_first_sum(const Block* block) noexcept nogil:
    """Sum the paths of a block by visiting each of them."""
    cdef int64_t here[MOST_VERTICES]  # vertex at each depth
    cdef uint64_t ahead[MOST_VERTICES]  # neighbours of it not tried yet
    cdef double value[MOST_VERTICES]  # weight of the path up to it, its own included
    cdef int64_t start, depth, v, u
    cdef uint64_t on_path, beyond
    cdef double reached, step
    cdef BlockSum found = BlockSum(0.0, 0.0)
    for start in range(block.count):
        reached = 0.0
        here[0], ahead[0], value[0] = start, block.near[start], 1.0
        on_path = bit(start)
        depth = 0
        while depth >= 0:
            v = here[depth]
            if ahead[depth] == 0:
                on_path ^= bit(v)
                depth -= 1
                continue
            u = lowest_bit(ahead[depth])
            ahead[depth] &= ahead[depth] - 1
            step = value[depth] * block.link[v * block.count + u]
            if u > start:  # else counted from u
                reached += step * block.ends[u]
            beyond = block.near[u] & ~on_path
            if beyond != 0:
                depth += 1
                on_path |= bit(u)
                here[depth], ahead[depth], value[depth] = u, beyond, step * block.inner[u]
        found.total += block.ends[start] * reached
        if start == 0:
            found.down = reached
    return found


cdef void find_twins(const Block* block, Twins* twins) noexcept nogil:
    """Group the vertices that can be swapped.

    Graphs of skeletons are full of them when all weights are equal, as in the kernel of a segment with itself:
    all joints of a hand move alike.
    """
    cdef int64_t u, group, stride = 1
    twins.count, twins.states = 0, 1.0
    for u in range(block.count):
        group = 1 if u > 0 else twins.count
        while group < twins.count and not _are_twins(block, u, twins.member[group]):
            group += 1
        twins.other[group] = u
        if group == twins.count:
            twins.count += 1
            twins.size[group], twins.member[group] = 0, u
        twins.states *= (twins.size[group] + 2.0) / (twins.size[group] + 1.0)
        twins.size[group] += 1
    for group in range(twins.count):
        twins.stride[group] = stride
        stride *= twins.size[group] + 1 if twins.states < 1e9 else 0


cdef bint _are_twins(const Block* block, int64_t u, int64_t v) noexcept nogil:
    """Return whether two vertices have equal weights and equal edges to all others."""
    cdef int64_t w, n = block.count
    if (block.near[u] & ~bit(v)) != (block.near[v] & ~bit(u)):
        return False
    if block.inner[u] != block.inner[v] or block.ends[u] != block.ends[v]:
        return False
    for w in range(n):
        if block.link[u * n + w] != block.link[v * n + w] and w != u and w != v:
            return False
    return True


cdef BlockSum subset_sum(const Block* block, const Twins* twins, void* room) noexcept nogil:
    """Sum the paths of a block by the sets they cover.

    A set is the number of covered members of each group of twins. ``sums[S, g]`` is the weight of all paths that
    cover the set S and end in the group g, without the weight of that end. Few sets of a sparse graph are covered
    by any path, so the groups where one ends are kept as bits of ``live[S]``.

    Args:
        block: The block.
        twins: Its twins, at most `MOST_GROUPS` groups.
        room: `subset_room` bytes.
    """
    cdef int64_t count = twins.count, states = _states(twins), state, vertices = 0, g, h
    cdef uint64_t* live = <uint64_t*>room
    cdef double* sums = <double*>(live + states)
    cdef double step[MOST_GROUPS * MOST_GROUPS]  # weight of an edge from a group to another or within it
    cdef uint64_t around_group[MOST_GROUPS]  # groups that edges lead to
    cdef int64_t covered[MOST_GROUPS]  # members of each group in the set, of which there are `vertices`
    cdef uint64_t vacant = bit(count) - 1  # groups with a member outside the set
    cdef uint64_t tips, around, rest
    cdef double reached
    cdef BlockSum found = BlockSum(0.0, 0.0)
    memset(live, 0, states * sizeof(uint64_t))
    for g in range(count):
        around_group[g], covered[g] = 0, 0
        for h in range(count):
            step[g * count + h] = block.link[
                twins.member[g] * block.count + (twins.other[h] if g == h else twins.member[h])
            ]
            around_group[g] |= bit(h) if step[g * count + h] != 0.0 else 0
        live[twins.stride[g]] = bit(g)
        sums[twins.stride[g] * count + g] = twins.size[g]
    for state in range(1, states):
        g = 0
        while covered[g] == twins.size[g]:  # count up
            vertices -= covered[g]
            covered[g] = 0
            vacant |= bit(g)
            g += 1
        covered[g] += 1
        vertices += 1
        vacant ^= bit(g) if covered[g] == twins.size[g] else 0
        tips = live[state]
        around, rest = 0, tips
        while rest != 0:
            g = lowest_bit(rest)
            rest &= rest - 1
            around |= around_group[g] & vacant
            if vertices == 1:
                sums[state * count + g] *= block.ends[twins.member[g]]
            else:
                found.total += sums[state * count + g] * block.ends[twins.member[g]]
                sums[state * count + g] *= block.inner[twins.member[g]]
        while around != 0:
            h = lowest_bit(around)
            around &= around - 1
            reached, rest = 0.0, tips & around_group[h]
            while rest != 0:
                g = lowest_bit(rest)
                rest &= rest - 1
                reached += sums[state * count + g] * step[h * count + g]
            live[state + twins.stride[h]] |= bit(h)
            sums[(state + twins.stride[h]) * count + h] = reached * (twins.size[h] - covered[h])
            if h == 0:
                found.down += reached
    found.total *= 0.5  # every path was built from both its ends
    return found


cdef inline int64_t _states(const Twins* twins) noexcept nogil:
    """Return the number of states of all groups, where it is not beyond use."""
    return twins.stride[twins.count - 1] * (twins.size[twins.count - 1] + 1)


cdef inline size_t subset_room(const Twins* twins) noexcept nogil:
    """Return the bytes that `subset_sum` needs: a set of groups and a number for each of them, for each state."""
    return <size_t>_states(twins) * (1 + <size_t>twins.count) * sizeof(double)
