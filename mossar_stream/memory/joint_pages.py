"""Joint pages: what is known of each joint, laid out so that loops over joints vectorise.

A loop is vectorised only where the compiler sees that the arrays it works on do not overlap. So they all lie in one
array, a constant distance apart: pages of `PAGE` joints, in each page one line for every number that is kept of a
joint. Joint j's number N is `body[place(j) + N]`; a loop over a page's joints takes `page[j + N]`, and all of a page,
for loops of a length that the compiler knows are straight-line code. What is computed where there is no joint stays 0,
or is not looked at.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import WIDTH, page_sum
from mossar_stream.jit.views import part

PAGE = WIDTH  # joints
POINT = np.dtype([("x", "f4"), ("y", "f4"), ("z", "f4")])  # m; a frame is J of these
FARTHEST = 1e5  # m; a coordinate beyond this is no position
X, Y, Z = 0, 32, 64  # m, where the joint is taken to be, in the source's space
GOOD_X, GOOD_Y, GOOD_Z = 96, 128, 160  # m, where it was last there
MOVED_X, MOVED_Y, MOVED_Z = 192, 224, 256  # m, displacement in this frame, relative to the centre
LAST_X, LAST_Y, LAST_Z = 288, 320, 352  # m, displacement in the frame before (noise)
SMOOTH_X, SMOOTH_Y, SMOOTH_Z = 384, 416, 448  # m, displacement with the noise smoothed out
MEAN_X, MEAN_Y, MEAN_Z = 480, 512, 544  # m, slow mean of the pose (tempo)
STEP, STEP_BEFORE = 576, 608  # m, path in this frame, and in the last one that was used
# Features of the last frame: where the joint is relative to the centre, m, and its log(m/s);
POSE_X, POSE_Y, POSE_Z, LOG_SPEED = 640, 672, 704, 736
SUM_X, SUM_Y, SUM_Z, SUM_SPEED = 768, 800, 832, 864  # sums of these over the frames that wait for a summary,
SQUARE_X, SQUARE_Y, SQUARE_Z, SQUARE_SPEED = 896, 928, 960, 992  # of their squares,
SUM_PATH = 1024  # and of the paths
LIVE = 1056  # 1, or 0 for joints that do not count (joints.py) and for what comes after the last joint
WORK = 1088  # scratch
REST_X, REST_Y, REST_Z = 1120, 1152, 1184  # m, the pose in which the performer dwells (scales)
LINES = 38  # of a page
PAGE_SIZE = LINES * PAGE
PAGE_BYTES = 4 * PAGE_SIZE
PADDING = 8  # joints are padded to a multiple of this, so that loops over joints vectorise


def pad(joints: int) -> int:
    """Return the number of padded joints for a number of joints."""
    return -(-joints // PADDING) * PADDING


def body_size(joints: int) -> int:
    """Return the length of the body of so many joints."""
    return -(-joints // PAGE) * PAGE_SIZE


@kernel
def place(j):
    """Return where joint j's numbers begin."""
    return j // PAGE * PAGE_SIZE + j % PAGE


@inline_kernel(returns_views=True)
def page_of(body, first):
    """Return the page that begins with a joint."""
    return part(body, first // PAGE * PAGE_BYTES, np.float32, (PAGE_SIZE,))


@inline_kernel
def line_sum(body, line):
    """Sum of a line of the body over all joints."""
    total = 0.0
    for first in range(0, len(body) // LINES, PAGE):
        total += page_sum(page_of(body, first), line)
    return total


@kernel
def center_of(plan, state, body):
    """Return where the centre is: the root, or the centroid of the joints that count.

    Args:
        plan: PLAN.
        state: JOINTS.
        body: The body.
    """
    if plan.center >= 0:
        k = place(plan.center)
        return body[k + X], body[k + Y], body[k + Z]
    x = y = z = live = 0.0
    for j in range(plan.joints):
        k = place(j)
        x += body[k + X] * body[k + LIVE]
        y += body[k + Y] * body[k + LIVE]
        z += body[k + Z] * body[k + LIVE]
        live += body[k + LIVE]
    live = max(live, 1.0)
    return (
        np.float32(x / live + state.offset_x),
        np.float32(y / live + state.offset_y),
        np.float32(z / live + state.offset_z),
    )


@kernel
def flatten(body, pose):
    """Copy the features of the last frame to where all joints follow each other; x is NaN where a joint does not count.

    Args:
        body: The body.
        pose: (4, padded_joints), set.
    """
    for first in range(0, pose.shape[1], PAGE):
        for axis in range(4):
            begin = first // PAGE * PAGE_SIZE + POSE_X + axis * PAGE
            line = pose[axis, first : first + PAGE]
            values = body[begin : begin + PAGE]
            for j in range(len(line)):
                line[j] = values[j]
    mark_absent(body, pose)


@kernel
def mark_absent(body, pose):
    """Set x to NaN, in a (4, padded_joints) pose, where a joint does not count."""
    for j in range(pose.shape[1]):
        if body[place(j) + LIVE] == 0.0:
            pose[0, j] = np.nan
