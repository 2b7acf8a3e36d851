"""How unlike a stretch of movement and an example are.

A stretch is described by `POINTS` poses at equal distances along its path (in the space of all coordinates): the unit
directions from each to the next, each joint's share of the path, and the box that each coordinate fills. The cost of
taking it for an example is the mean of 1 - cos over the directions, warped by at most `REACH` of them. It is divided by
the cosine of the shares and by the sixth power of that of the boxes, and multiplied by a factor for another posture.
The published recogniser divides by both once; where one example of each move by other people has to tell, the sixth
power makes a third of the mistakes (14 moves of 11 people, 1.9 % instead of 5.3 %; of 17 moves of 5 people 0.4 % either
way).
"""

cdef enum:
    POINTS = 16
    DIRECTIONS = POINTS - 1
    REACH = 2  # directions by which warping may go astray
cdef float LEAST_COST = 0.05000000074505806  # mean of 1 - cos that no two performances go below
cdef double SIZE_FREE = 1.1  # by which sizes may differ at no cost
cdef double CARRIED_FREE = 2.0  # the same for how far the centre of the body is carried
cdef float CARRIED_LEAST = 0.10000000149011612  # m, that is added to both: less is sway
cdef float STANCE_FREE = 0.949999988079071  # cosine between two mean postures, below which it costs
cdef float STANCE_STEEP = 13.0  # how much more the natural logarithm of the cost is for each 1 below
cdef float STEADY = 0.75  # share of a body's steady turn that is taken back
cdef float NEVER = 1.0000000150474662e+30

cdef struct Description:  # One stretch of movement.
    FloatRows points  # (POINTS, D) m, poses at equal distances along the path
    FloatRows directions  # (DIRECTIONS, D) unit length
    Floats shares  # (K padded,) unit length, path of each joint
    Floats stance  # (D,) unit length, mean posture: joints relative to the centre
    Floats box  # (D,) unit length, extent of each coordinate
    Floats size  # (1,) m, diagonal of the box
    Floats low  # (D,) m, least value of each coordinate
    FloatRows row  # (2, DIRECTIONS + 1) two lines of the table of warping


cdef inline float scale_to_one(Floats line) noexcept nogil:
    """Give a padded line the length 1 and return the length it had; a line of zeros stays."""
    cdef float length, factor
    cdef int64_t i
    length = sqrtf(line_product(line.at, line.at))
    if length > 0.0:
        factor = <float>1.0 / length
        for i in range(line.count):
            line.at[i] *= factor
    return length


cdef void measure_describe(FloatRows poses, Doubles path, int64_t first, int64_t last, MoveBank* bank) noexcept nogil:
    """Describe the stretch from pose number `first` to `last`.

    Args:
        poses: (H, D) float32 metres, a ring: pose n lies in line n % H.
        path: (H,) float64 metres, length of the path up to each pose, another ring.
        first: Number of the first pose.
        last: Number of the last one, above `first`, less than H later.
        bank: With `joints`, the first three coordinates being the first joint's; `scratch`, the description to write to; and
            `girdles`, (4,) of these joints, see `facing.GIRDLES`: the stretch is described as of a body that faces +z. Without
            hips (-1) it is described as it was made.
    """
    cdef int64_t j, joints
    cdef Ints girdles
    cdef Description* found
    joints = bank.joints.count
    girdles = bank.girdles
    found = &bank.scratch
    _equal_steps(poses, path, first, last, found.points)
    if girdles.at[0] >= 0 and girdles.at[1] >= 0:
        _turn_to_front(found.points, joints, girdles, found.row)
    _stance(found.points, found.stance)
    _directions(found.points, found.directions, found.low)
    for j in range(joints):
        found.shares.at[j] = sqrtf(found.low.at[3 * j] + found.low.at[3 * j + 1] + found.low.at[3 * j + 2])
    scale_to_one(found.shares)
    _measure_box(found.points, found.low, found.box)
    found.size.at[0] = scale_to_one(found.box)


cdef void _equal_steps(FloatRows poses, Doubles path, int64_t first, int64_t last, FloatRows points) noexcept nogil:
    cdef int64_t ring, here, i, d, before, after
    cdef double begin, step, wanted, way
    cdef float share
    # CHECK sign (C truncates): first % ring; last % ring; (here + 1) % ring; here % ring
    ring = path.count
    begin = path.at[first % ring]
    step = (path.at[last % ring] - begin) / DIRECTIONS
    here = first
    for i in range(POINTS):
        wanted = begin + step * i
        while here + 1 < last and path.at[(here + 1) % ring] < wanted:
            here += 1
        before, after = here % ring, (here + 1) % ring
        way = path.at[after] - path.at[before]
        share = <float>min(1.0, (wanted - path.at[before]) / way) if way > 0.0 else <float>0.0
        for d in range(points.columns):
            points.at[i * points.columns + d] = poses.at[before * poses.columns + d] + share * (poses.at[after * poses.columns + d] - poses.at[before * poses.columns + d])


cdef void _turn_to_front(FloatRows points, int64_t joints, Ints girdles, FloatRows facings) noexcept nogil:
    """Turn a stretch about the vertical, so that the body faces +z on average and no longer turns steadily.

    Args:
        points: (POINTS, D) m; the centre is counted from where it was first.
        joints: Number of joints.
        girdles: (4,) of them.
        facings: (2, POINTS + 1), scratch; every other point is enough.
    """
    cdef float x, z, begin_x, begin_z
    cdef int64_t i, d
    cdef double step, first, cosine, sine, step_cosine, step_sine
    # CHECK call points[i, :3 * joints].reshape((joints, 3))
    # CHECK facing_of is called with several kinds of arguments
    # CHECK heading is called with several kinds of arguments
    # CHECK turned_back is called with several kinds of arguments
    x = z = <float>0.0
    for i in range(0, POINTS, 2):
        facings.at[i], facings.at[1 * facings.columns + i] = facing_of(points[i, : 3 * joints].reshape((joints, 3)), girdles)
        x += facings.at[i]
        z += facings.at[1 * facings.columns + i]
    cosine, sine = heading(x, z)
    step = STEADY * _turn_of_a_step(facings, cosine, sine)
    first = <float>(0.5 * DIRECTIONS) * step
    cosine, sine = _sum_of_turns(cosine, sine, cos(first), -sin(first))
    step_cosine, step_sine = cos(step), sin(step)
    begin_x, begin_z = points.at[0], points.at[2]
    for i in range(POINTS):
        points.at[i * points.columns + 0] -= begin_x
        points.at[i * points.columns + 2] -= begin_z
        for d in range(0, 3 * joints, 3):
            points.at[i * points.columns + d], points.at[i * points.columns + (d + 2)] = turned_back(points.at[i * points.columns + d], points.at[i * points.columns + (d + 2)], cosine, sine)
        cosine, sine = _sum_of_turns(cosine, sine, step_cosine, step_sine)


cdef inline double _turn_of_a_step(FloatRows facings, double cosine, double sine) noexcept nogil:
    """Return by how much a body that is described turns from each point to the next, rad: the slope of a straight line."""
    cdef double products, squares, length, x, z
    cdef int64_t i
    cdef float place
    # CHECK sign (C truncates): DIRECTIONS // 2
    # CHECK numba gave products the types float32, float64
    # CHECK numba gave squares the types float32, float64
    # CHECK turned_back is called with several kinds of arguments
    products = <float>0.0
    squares = <float>1e-6
    for i in range(0, POINTS, 2):
        x, z = turned_back(facings.at[i], facings.at[1 * facings.columns + i], cosine, sine)
        length = sqrt(x * x + z * z)  # of a body that leans, the facing says less
        place = <float>(i - DIRECTIONS // 2)
        products += length * place * atan2(x, z)
        squares += length * place * place
    return products / squares


cdef inline (double, double) _sum_of_turns(double cosine, double sine, double other_cosine, double other_sine) noexcept nogil:
    return cosine * other_cosine - sine * other_sine, sine * other_cosine + cosine * other_sine


cdef inline void _stance(FloatRows points, Floats stance) noexcept nogil:
    cdef int64_t d, i
    for d in range(stance.count):
        stance.at[d] = points.at[d]
    for i in range(1, POINTS):
        for d in range(stance.count):
            stance.at[d] += points.at[i * points.columns + d]
    for d in range(3):  # where the body is does not matter
        stance.at[d] = <float>0.0
    scale_to_one(stance)


cdef inline void _directions(FloatRows points, FloatRows directions, Floats squares) noexcept nogil:
    """Write the unit directions from each point to the next, and the sum of their squares in each coordinate."""
    cdef int64_t i, d
    for i in range(DIRECTIONS):
        for d in range(squares.count):
            directions.at[i * directions.columns + d] = points.at[(i + 1) * points.columns + d] - points.at[i * points.columns + d]
    for i in range(DIRECTIONS):
        scale_to_one(row_of_floats(directions, i))
    for d in range(squares.count):
        squares.at[d] = <float>0.0
    for i in range(DIRECTIONS):
        for d in range(squares.count):
            squares.at[d] += directions.at[i * directions.columns + d] * directions.at[i * directions.columns + d]


cdef void first_half(Description* found) noexcept nogil:
    """Let the box be that of the first half of the stretch, m."""
    # CHECK sign (C truncates): POINTS // 2
    _measure_box(rows_of_floats(found.points, 0, POINTS // 2 + 1), found.low, found.box)


cdef inline void _measure_box(FloatRows points, Floats low, Floats box) noexcept nogil:
    cdef int64_t d, i
    for d in range(box.count):
        low.at[d] = box.at[d] = points.at[d]
    for i in range(1, points.rows):
        for d in range(box.count):
            box.at[d] = max(box.at[d], points.at[i * points.columns + d])
            low.at[d] = min(low.at[d], points.at[i * points.columns + d])
    for d in range(box.count):
        box.at[d] -= low.at[d]


cdef inline float strangeness(Description* found, Floats stance) noexcept nogil:
    """Return what the cost is multiplied by because the mean posture is another one.

    Who makes a move that was shown holds the body as when it was shown, far more exactly than other people or other
    movements do: over a whole performance the cosine is above 0.98 in the same player and mostly above 0.95 in others.
    """
    cdef float alike
    alike = line_product(found.stance.at, stance.at)
    if alike >= STANCE_FREE:
        return <float>1.0
    return expf(STANCE_STEEP * (STANCE_FREE - alike))


cdef inline float correction(Description* found, Floats box, Floats shares, float size) noexcept nogil:
    """Return what the directions' cost is multiplied by: shares, boxes and sizes that differ, and the body's own way.

    Of the centre's way the boxes say little, because all other joints are relative to it; but a duck or a jump
    moves the whole body, and a kick or a swing of the arms does not.
    """
    cdef float boxes, ratio, sizes, carried, cube
    # CHECK types of shares: ['float32', 'float32[1C]']
    # CHECK numba gave shares the types float32, float32[1C]
    shares = max(line_product(found.shares.at, shares.at), <float>1e-3)
    boxes = max(line_product(found.box.at, box.at), <float>1e-3)
    ratio = found.size.at[0] / size
    ratio = max(ratio, <float>1.0 / max(ratio, <float>1e-6)) / <float>SIZE_FREE
    sizes = sqrtf(sqrtf(max(ratio, <float>1.0)))
    carried = (_extent_of_centre(found.box) * found.size.at[0] + CARRIED_LEAST) / (_extent_of_centre(box) * size + CARRIED_LEAST)
    carried = max(carried, <float>1.0 / carried) / <float>CARRIED_FREE
    cube = boxes * boxes * boxes
    return sizes * max(carried, <float>1.0) / (shares * cube * cube)


cdef inline float _extent_of_centre(Floats box) noexcept nogil:
    return sqrtf(box.at[0] * box.at[0] + box.at[1] * box.at[1] + box.at[2] * box.at[2])


cdef float warped(Description* found, FloatRows template, float limit) noexcept nogil:
    """Return the mean of 1 - cos between the directions of a stretch and of an example, warped.

    Args:
        found: Description of the stretch.
        template: (DIRECTIONS, D) of the example.
        limit: Give up, and return `NEVER`, once it must be above this.
    """
    cdef float most, least, way
    cdef int64_t i, j
    cdef Floats before, line
    most = limit * <float>DIRECTIONS
    before = row_of_floats(found.row, 0)
    line = row_of_floats(found.row, 1)
    from_floats(before, 0) = NEVER
    before.at[0] = <float>0.0
    for i in range(DIRECTIONS):
        from_floats(line, 0) = NEVER
        least = NEVER
        for j in range(max(0, i - REACH), min(DIRECTIONS, i + REACH + 1)):
            way = min(before.at[j], before.at[j + 1], line.at[j])
            line.at[j + 1] = way + (<float>1.0 - line_product(row_of_floats(found.directions, i).at, row_of_floats(template, j).at))
            least = min(least, line.at[j + 1])
        if least > most:
            return NEVER
        before = line
        line = before
    return before.at[DIRECTIONS] / <float>DIRECTIONS
