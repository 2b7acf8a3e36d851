"""Mean pose: leaky means of the pose, which the size of the movements is measured from (tempo, scales)."""

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import page_sum
from mossar_stream.memory.joint_pages import (
    LINES,
    PAGE,
    POSE_X,
    POSE_Y,
    POSE_Z,
    WORK,
    X,
    Y,
    Z,
    page_of,
    place,
)

MEAN_TIME = 5.0  # s, of slow means


@kernel
def start_mean(body, joints, line):
    """Begin a mean with the pose of the last frame.

    Args:
        body: See joint_pages.py.
        joints: J.
        line: Where x of the mean stands in a page; y and z follow.
    """
    for j in range(joints):
        k = place(j)
        for axis in range(3):
            body[k + line + axis * PAGE] = body[k + POSE_X + axis * PAGE]


@inline_kernel
def follow_mean(body, line, share):
    """Let a mean follow the pose of the last frame, whose weight is `share`, float32."""
    for first in range(0, len(body) // LINES, PAGE):
        page = page_of(body, first)
        for j in range(PAGE):
            page[j + line + X] += share * (page[j + POSE_X] - page[j + line + X])
            page[j + line + Y] += share * (page[j + POSE_Y] - page[j + line + Y])
            page[j + line + Z] += share * (page[j + POSE_Z] - page[j + line + Z])


@inline_kernel
def squared_distance(body, line):
    """Return the sum over the joints of their squared distances from a mean, m²; uses WORK."""
    squares = 0.0
    for first in range(0, len(body) // LINES, PAGE):
        page = page_of(body, first)
        for j in range(PAGE):
            u = page[j + POSE_X] - page[j + line + X]
            v = page[j + POSE_Y] - page[j + line + Y]
            w = page[j + POSE_Z] - page[j + line + Z]
            page[j + WORK] = u * u + v * v + w * w
        squares += page_sum(page, WORK)
    return squares
