"""The cost of taking a stretch of movement for an example.

A stretch is described by `POINTS` poses at equal distances along its path (in the space of all coordinates):
the unit directions from each to the next, each joint's share of the path, and the box that each coordinate
fills. The cost of taking it for an example is the mean of 1 - cos over the directions, warped by at most
`REACH` of them. It is divided by the cosine of the shares and by the sixth power of that of the boxes, and
multiplied by a factor for another posture. The published recogniser divides by both once. With one example of
each move by other people, the sixth power makes a third of the mistakes (14 moves of 11 people, 1.9 % instead
of 5.3 %; of 17 moves of 5 people 0.4 % either way).
"""

cdef enum:
    POINTS = 16
    DIRECTIONS = POINTS - 1
    REACH = 2  # directions by which warping may go astray
cdef float LEAST_COST = 0.05  # mean of 1 - cos that no two performances go below
cdef float SIZE_FREE = 1.1  # by which sizes may differ at no cost
cdef float CARRIED_FREE = 2.0  # the same for the way of the body's centre
cdef float CARRIED_LEAST = 0.1  # m, added to both: less is sway
cdef float STANCE_FREE = 0.95  # cosine between two mean postures, below which the cost rises
cdef float STANCE_STEEP = 13.0  # rise of the cost's natural logarithm for each 1 below
cdef double STEADY = 0.75  # share of a body's steady turn that is taken back
cdef float NEVER = 1e30

cdef struct Description:  # One stretch of movement.
    FloatRows points  # (POINTS, D) m, poses at equal distances along the path
    FloatRows directions  # (DIRECTIONS, D) unit length
    Floats shares  # (D,) unit length, path of each joint, then zeros
    Floats stance  # (D,) unit length, mean posture: joints relative to the centre
    Floats box  # (D,) unit length, extent of each coordinate
    Floats low  # (D,) m, least value of each coordinate
    float* size  # (1,) m, diagonal of the box
    FloatRows row  # (2, DIRECTIONS + 1) two lines of the table of warping


cdef inline float scale_to_one(Floats line) noexcept nogil:
    """Give a padded line the length 1 and return the length it had; a line of zeros stays."""
    cdef float length, factor
    cdef int64_t i
    length = sqrtf(line_product(line.at, line.at, line.count))
    if length > 0.0:
        factor = <float>1.0 / length
        for i in range(line.count):
            line.at[i] *= factor
    return length


cdef void describe_stretch(
    FloatRows poses, Doubles path, int64_t first, int64_t last,
    int64_t joints, const int64_t* girdles, Description* found,
) noexcept nogil:
    """Describe the stretch from pose number `first` to `last`.

    Args:
        poses: (H, D) m, a ring: pose n lies in line n % H; the first three numbers are the first joint's.
        path: (H,) m, length of the path up to each pose, another ring.
        first: Number of the first pose.
        last: Number of the last one, above `first`, less than H later.
        joints: Number of joints.
        girdles: Four of these joints, see `facing_of`: the stretch is described as of a body that faces +z.
            Without hips (-1) it is not turned.
        found: Gets the description.
    """
    cdef const float* squares
    cdef int64_t j
    _equal_steps(poses, path, first, last, found.points)
    if girdles[0] >= 0 and girdles[1] >= 0:
        _turn_to_front(found.points, joints, girdles, found.row)
    _stance(found.points, found.stance)
    _directions(found.points, found.directions, found.low)
    for j in range(joints):
        squares = found.low.at + 3 * j
        found.shares.at[j] = sqrtf(squares[0] + squares[1] + squares[2])
    scale_to_one(found.shares)
    _box(found.points, found.low, found.box)
    found.size[0] = scale_to_one(found.box)


cdef void _equal_steps(
    FloatRows poses, Doubles path, int64_t first, int64_t last, FloatRows points
) noexcept nogil:
    cdef const float* earlier
    cdef const float* later
    cdef float* point
    cdef float share
    cdef double begin, step, wanted, way
    cdef int64_t ring, here, i, d, before, after
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
        point = points.at + i * points.columns
        earlier, later = poses.at + before * poses.columns, poses.at + after * poses.columns
        for d in range(points.columns):
            point[d] = earlier[d] + share * (later[d] - earlier[d])


cdef void _turn_to_front(
    FloatRows points, int64_t joints, const int64_t* girdles, FloatRows facings
) noexcept nogil:
    """Turn a stretch about the vertical, so that the body faces +z on average and no longer turns steadily.

    Args:
        points: (POINTS, D) m; the centre is relative to its first place.
        joints: Number of joints.
        girdles: Four of them.
        facings: (2, POINTS), scratch; every other point is enough.
    """
    cdef float* point
    cdef float x, z, begin_x, begin_z
    cdef double step, first, cosine, sine, step_cosine, step_sine
    cdef int64_t i, d
    x = z = 0.0
    for i in range(0, POINTS, 2):
        facings.at[i], facings.at[facings.columns + i] = facing_of(
            floats_in_rows(points.at + i * points.columns, joints, 3), girdles
        )
        x += facings.at[i]
        z += facings.at[facings.columns + i]
    cosine, sine = heading_in_floats(x, z)
    step = STEADY * _turn_of_a_step(facings, cosine, sine)
    first = 0.5 * DIRECTIONS * step
    cosine, sine = _sum_of_turns(cosine, sine, cos(first), -sin(first))
    step_cosine, step_sine = cos(step), sin(step)
    begin_x, begin_z = points.at[0], points.at[2]
    for i in range(POINTS):
        point = points.at + i * points.columns
        point[0] -= begin_x
        point[2] -= begin_z
        for d in range(0, 3 * joints, 3):
            point[d], point[d + 2] = turned_back(point[d], point[d + 2], cosine, sine)
        cosine, sine = _sum_of_turns(cosine, sine, step_cosine, step_sine)


cdef inline double _turn_of_a_step(FloatRows facings, double cosine, double sine) noexcept nogil:
    """Return the turn of a body from each point to the next, rad: the slope of a straight line."""
    cdef double products, squares, length, place, x, z
    cdef int64_t i
    products = 0.0
    squares = <float>1e-6
    for i in range(0, POINTS, 2):
        x, z = turned_back(facings.at[i], facings.at[facings.columns + i], cosine, sine)
        length = sqrt(x * x + z * z)  # the facing of a leaning body is less certain
        place = i - DIRECTIONS // 2
        products += length * place * atan2(x, z)
        squares += length * place * place
    return products / squares


cdef inline (double, double) _sum_of_turns(
    double cosine, double sine, double other_cosine, double other_sine
) noexcept nogil:
    return cosine * other_cosine - sine * other_sine, sine * other_cosine + cosine * other_sine


# One plain loop after the other, because the compiler makes several numbers at once of each.
cdef inline void _stance(FloatRows points, Floats stance) noexcept nogil:
    cdef int64_t d, i
    for d in range(stance.count):
        stance.at[d] = points.at[d]
    for i in range(1, POINTS):
        for d in range(stance.count):
            stance.at[d] += points.at[i * points.columns + d]
    for d in range(3):  # the place of the body does not matter
        stance.at[d] = 0.0
    scale_to_one(stance)


cdef inline void _directions(FloatRows points, FloatRows directions, Floats squares) noexcept nogil:
    """Write the unit directions from point to point, and the sum of their squares in each coordinate."""
    cdef const float* point
    cdef const float* direction
    cdef int64_t i, d
    for i in range(DIRECTIONS):
        point = points.at + i * points.columns
        for d in range(squares.count):
            directions.at[i * directions.columns + d] = point[points.columns + d] - point[d]
    for i in range(DIRECTIONS):
        scale_to_one(row_of_floats(directions, i))
    for d in range(squares.count):
        squares.at[d] = 0.0
    for i in range(DIRECTIONS):
        direction = directions.at + i * directions.columns
        for d in range(squares.count):
            squares.at[d] += direction[d] * direction[d]


cdef void first_half(Description* found) noexcept nogil:
    """Set the box to that of the first half of the stretch, m."""
    _box(rows_of_floats(found.points, 0, POINTS // 2 + 1), found.low, found.box)


cdef inline void _box(FloatRows points, Floats low, Floats box) noexcept nogil:
    cdef const float* point
    cdef int64_t d, i
    for d in range(box.count):
        low.at[d] = box.at[d] = points.at[d]
    for i in range(1, points.rows):
        point = points.at + i * points.columns
        for d in range(box.count):
            box.at[d] = max(box.at[d], point[d])
            low.at[d] = min(low.at[d], point[d])
    for d in range(box.count):
        box.at[d] -= low.at[d]


cdef inline float strangeness(Description* found, const float* stance) noexcept nogil:
    """Return the factor of the cost for another mean posture.

    A performer repeats the posture of a shown move far more exactly than other people, or other movements, do: over
    a whole performance the cosine is above 0.98 for the same player and mostly above 0.95 for others.
    """
    cdef float alike
    alike = line_product(found.stance.at, stance, found.stance.count)
    if alike >= STANCE_FREE:
        return 1.0
    return expf(STANCE_STEEP * (STANCE_FREE - alike))


cdef inline float correction(
    Description* found, const float* box, const float* shares, float size
) noexcept nogil:
    """Return the factor of the directions' cost for shares, boxes, sizes and the way of the centre.

    The boxes contain little of the centre's way, because all other joints are relative to it. But a duck or a jump
    moves the whole body, and a kick or a swing of the arms does not.
    """
    cdef float alike_shares, alike_boxes, ratio, sizes, carried, cube
    alike_shares = max(line_product(found.shares.at, shares, found.shares.count), <float>1e-3)
    alike_boxes = max(line_product(found.box.at, box, found.box.count), <float>1e-3)
    ratio = found.size[0] / size
    ratio = max(ratio, <float>1.0 / max(ratio, <float>1e-6)) / SIZE_FREE
    sizes = sqrtf(sqrtf(max(ratio, <float>1.0)))
    carried = (_extent_of_centre(found.box.at) * found.size[0] + CARRIED_LEAST) / (
        _extent_of_centre(box) * size + CARRIED_LEAST
    )
    carried = max(carried, <float>1.0 / carried) / CARRIED_FREE
    cube = alike_boxes * alike_boxes * alike_boxes
    return sizes * max(carried, <float>1.0) / (alike_shares * cube * cube)


cdef inline float _extent_of_centre(const float* box) noexcept nogil:
    return sqrtf(box[0] * box[0] + box[1] * box[1] + box[2] * box[2])


cdef float warped(Description* found, FloatRows template, float limit) noexcept nogil:
    """Return the mean of 1 - cos between the directions of a stretch and of an example, warped.

    Args:
        found: Description of the stretch.
        template: (DIRECTIONS, D) of the example.
        limit: Give up, and return `NEVER`, once it must be above this.
    """
    cdef float* before
    cdef float* line
    cdef const float* direction
    cdef float most, least, way
    cdef int64_t i, j, columns
    most = limit * <float>DIRECTIONS
    columns = template.columns
    before, line = found.row.at, found.row.at + found.row.columns
    _fill(before)
    before[0] = 0.0
    for i in range(DIRECTIONS):
        _fill(line)
        least = NEVER
        direction = found.directions.at + i * columns
        for j in range(max(0, i - REACH), min(DIRECTIONS, i + REACH + 1)):
            way = min(before[j], before[j + 1], line[j])
            way += <float>1.0 - line_product(direction, template.at + j * columns, columns)
            line[j + 1] = way
            least = min(least, way)
        if least > most:
            return NEVER
        before, line = line, before
    return before[DIRECTIONS] / <float>DIRECTIONS


cdef inline void _fill(float* line) noexcept nogil:
    cdef int64_t j
    for j in range(DIRECTIONS + 1):
        line[j] = NEVER
