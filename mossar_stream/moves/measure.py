"""How unlike a stretch of movement and an example are.

A stretch is described by `POINTS` poses at equal distances along its path (in the space of all coordinates): the unit
directions from each to the next, each joint's share of the path, and the box that each coordinate fills. The cost of
taking it for an example is the mean of 1 - cos over the directions, warped by at most `REACH` of them. It is divided by
the cosine of the shares and by the sixth power of that of the boxes, and multiplied by a factor for another posture.
The published recogniser divides by both once; where one example of each move by other people has to tell, the sixth
power makes a third of the mistakes (14 moves of 11 people, 1.9 % instead of 5.3 %; of 17 moves of 5 people 0.4 % either
way).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import line_product
from mossar_stream.moves.facing import facing_of, heading, turned_back

POINTS = 16
DIRECTIONS = POINTS - 1
REACH = 2  # directions by which warping may go astray
LEAST_COST = np.float32(0.05)  # mean of 1 - cos that no two performances go below
SIZE_FREE = 1.1  # by which sizes may differ at no cost
CARRIED_FREE = 2.0  # the same for how far the centre of the body is carried
CARRIED_LEAST = np.float32(0.1)  # m, that is added to both: less is sway
STANCE_FREE = np.float32(0.95)  # cosine between two mean postures, below which it costs
STANCE_STEEP = np.float32(13.0)  # how much more the natural logarithm of the cost is for each 1 below
STEADY = np.float32(0.75)  # share of a body's steady turn that is taken back
NEVER = np.float32(1e30)


class Description(NamedTuple):
    """One stretch of movement."""

    points: NDArray[np.float32]  # (POINTS, D) m, poses at equal distances along the path
    directions: NDArray[np.float32]  # (DIRECTIONS, D) unit length
    shares: NDArray[np.float32]  # (K padded,) unit length, path of each joint
    stance: NDArray[np.float32]  # (D,) unit length, mean posture: joints relative to the centre
    box: NDArray[np.float32]  # (D,) unit length, extent of each coordinate
    size: NDArray[np.float32]  # (1,) m, diagonal of the box
    low: NDArray[np.float32]  # (D,) m, least value of each coordinate
    row: NDArray[np.float32]  # (2, DIRECTIONS + 1) two lines of the table of warping


@inline_kernel
def scale_to_one(line):
    """Give a padded line the length 1 and return the length it had; a line of zeros stays."""
    length = np.sqrt(line_product(line, line))
    if length > 0.0:
        factor = np.float32(1.0) / length
        for i in range(line.size):
            line[i] *= factor
    return length


@kernel
def describe(poses, path, first, last, bank):
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
    joints, girdles, found = bank.joints.size, bank.girdles, bank.scratch
    _equal_steps(poses, path, first, last, found.points)
    if girdles[0] >= 0 and girdles[1] >= 0:
        _turn_to_front(found.points, joints, girdles, found.row)
    _stance(found.points, found.stance)
    _directions(found.points, found.directions, found.low)
    for j in range(joints):
        found.shares[j] = np.sqrt(found.low[3 * j] + found.low[3 * j + 1] + found.low[3 * j + 2])
    scale_to_one(found.shares)
    _box(found.points, found.low, found.box)
    found.size[0] = scale_to_one(found.box)


@kernel
def _equal_steps(poses, path, first, last, points):
    ring = path.size
    begin = path[first % ring]
    step = (path[last % ring] - begin) / DIRECTIONS
    here = first
    for i in range(POINTS):
        wanted = begin + step * i
        while here + 1 < last and path[(here + 1) % ring] < wanted:
            here += 1
        before, after = here % ring, (here + 1) % ring
        way = path[after] - path[before]
        share = np.float32(min(1.0, (wanted - path[before]) / way)) if way > 0.0 else np.float32(0.0)
        for d in range(points.shape[1]):
            points[i, d] = poses[before, d] + share * (poses[after, d] - poses[before, d])


@kernel
def _turn_to_front(points, joints, girdles, facings):
    """Turn a stretch about the vertical, so that the body faces +z on average and no longer turns steadily.

    Args:
        points: (POINTS, D) m; the centre is counted from where it was first.
        joints: Number of joints.
        girdles: (4,) of them.
        facings: (2, POINTS + 1), scratch; every other point is enough.
    """
    x = z = np.float32(0.0)
    for i in range(0, POINTS, 2):
        facings[0, i], facings[1, i] = facing_of(points[i, : 3 * joints].reshape((joints, 3)), girdles)
        x += facings[0, i]
        z += facings[1, i]
    cosine, sine = heading(x, z)
    step = STEADY * _turn_of_a_step(facings, cosine, sine)
    first = np.float32(0.5 * DIRECTIONS) * step
    cosine, sine = _sum_of_turns(cosine, sine, np.cos(first), -np.sin(first))
    step_cosine, step_sine = np.cos(step), np.sin(step)
    begin_x, begin_z = points[0, 0], points[0, 2]
    for i in range(POINTS):
        points[i, 0] -= begin_x
        points[i, 2] -= begin_z
        for d in range(0, 3 * joints, 3):
            points[i, d], points[i, d + 2] = turned_back(points[i, d], points[i, d + 2], cosine, sine)
        cosine, sine = _sum_of_turns(cosine, sine, step_cosine, step_sine)


@inline_kernel
def _turn_of_a_step(facings, cosine, sine):
    """Return by how much a body that is described turns from each point to the next, rad: the slope of a straight line."""
    products = np.float32(0.0)
    squares = np.float32(1e-6)
    for i in range(0, POINTS, 2):
        x, z = turned_back(facings[0, i], facings[1, i], cosine, sine)
        length = np.sqrt(x * x + z * z)  # of a body that leans, the facing says less
        place = np.float32(i - DIRECTIONS // 2)
        products += length * place * np.arctan2(x, z)
        squares += length * place * place
    return products / squares


@inline_kernel
def _sum_of_turns(cosine, sine, other_cosine, other_sine):
    return cosine * other_cosine - sine * other_sine, sine * other_cosine + cosine * other_sine


# One plain loop after the other, because the compiler makes several numbers at once of each.
@inline_kernel
def _stance(points, stance):
    for d in range(stance.size):
        stance[d] = points[0, d]
    for i in range(1, POINTS):
        for d in range(stance.size):
            stance[d] += points[i, d]
    for d in range(3):  # where the body is does not matter
        stance[d] = np.float32(0.0)
    scale_to_one(stance)


@inline_kernel
def _directions(points, directions, squares):
    """Write the unit directions from each point to the next, and the sum of their squares in each coordinate."""
    for i in range(DIRECTIONS):
        for d in range(squares.size):
            directions[i, d] = points[i + 1, d] - points[i, d]
    for i in range(DIRECTIONS):
        scale_to_one(directions[i])
    for d in range(squares.size):
        squares[d] = np.float32(0.0)
    for i in range(DIRECTIONS):
        for d in range(squares.size):
            squares[d] += directions[i, d] * directions[i, d]


@kernel
def first_half(found):
    """Let the box be that of the first half of the stretch, m."""
    _box(found.points[: POINTS // 2 + 1], found.low, found.box)


@inline_kernel
def _box(points, low, box):
    for d in range(box.size):
        low[d] = box[d] = points[0, d]
    for i in range(1, points.shape[0]):
        for d in range(box.size):
            box[d] = max(box[d], points[i, d])
            low[d] = min(low[d], points[i, d])
    for d in range(box.size):
        box[d] -= low[d]


@inline_kernel
def strangeness(found, stance):
    """Return what the cost is multiplied by because the mean posture is another one.

    Who makes a move that was shown holds the body as when it was shown, far more exactly than other people or other
    movements do: over a whole performance the cosine is above 0.98 in the same player and mostly above 0.95 in others.
    """
    alike = line_product(found.stance, stance)
    if alike >= STANCE_FREE:
        return np.float32(1.0)
    return np.exp(STANCE_STEEP * (STANCE_FREE - alike))


@inline_kernel
def correction(found, box, shares, size):
    """Return what the directions' cost is multiplied by: shares, boxes and sizes that differ, and the body's own way.

    Of the centre's way the boxes say little, because all other joints are relative to it; but a duck or a jump
    moves the whole body, and a kick or a swing of the arms does not.
    """
    shares = max(line_product(found.shares, shares), np.float32(1e-3))
    boxes = max(line_product(found.box, box), np.float32(1e-3))
    ratio = found.size[0] / size
    ratio = max(ratio, np.float32(1.0) / max(ratio, np.float32(1e-6))) / np.float32(SIZE_FREE)
    sizes = np.sqrt(np.sqrt(max(ratio, np.float32(1.0))))
    carried = (_extent_of_centre(found.box) * found.size[0] + CARRIED_LEAST) / (
        _extent_of_centre(box) * size + CARRIED_LEAST
    )
    carried = max(carried, np.float32(1.0) / carried) / np.float32(CARRIED_FREE)
    cube = boxes * boxes * boxes
    return sizes * max(carried, np.float32(1.0)) / (shares * cube * cube)


@inline_kernel
def _extent_of_centre(box):
    return np.sqrt(box[0] * box[0] + box[1] * box[1] + box[2] * box[2])


@kernel
def warped(found, template, limit):
    """Return the mean of 1 - cos between the directions of a stretch and of an example, warped.

    Args:
        found: Description of the stretch.
        template: (DIRECTIONS, D) of the example.
        limit: Give up, and return `NEVER`, once it must be above this.
    """
    most = limit * np.float32(DIRECTIONS)
    before, line = found.row[0], found.row[1]
    before[:] = NEVER
    before[0] = np.float32(0.0)
    for i in range(DIRECTIONS):
        line[:] = NEVER
        least = NEVER
        for j in range(max(0, i - REACH), min(DIRECTIONS, i + REACH + 1)):
            way = min(before[j], before[j + 1], line[j])
            line[j + 1] = way + (np.float32(1.0) - line_product(found.directions[i], template[j]))
            least = min(least, line[j + 1])
        if least > most:
            return NEVER
        before, line = line, before
    return before[DIRECTIONS] / np.float32(DIRECTIONS)
