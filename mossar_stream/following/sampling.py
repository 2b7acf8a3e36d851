"""Sampling: frames in, the directions of bones out, at a fixed rate whatever the sensor's.

Samples lie on a grid of `PERIOD`, between two frames by interpolation, so that alignments count time, not frames.
"""

import numpy as np

from mossar_stream.following.views import first_pose
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.moves.facing import facing_of, heading, turned_back
from mossar_stream.moves.points import is_hidden, place_points

FACING_TIME = 1.0  # s, time constant with which the facing follows
SMALLEST = np.float32(1e-6)  # m, of a bone
EARLY = 1e-6  # s by which a frame may come before the sample that is due
LEAST_SPACING = 1e-9  # s, frames nearer than this are one
LONGEST_HOLE = np.float32(0.1)  # s for which a point may be missing without its bones being hidden


@inline_kernel
def place_pose(pose, bank, positions):
    """Set a pose to the points of a frame relative to the centre; return whether all were there."""
    head = bank.head[0]
    whole = place_points(pose, bank.points, positions, (head.axis, head.sign))
    for d in range(3):  # directions of bones do not depend on where the body is
        pose[0, d] = np.float32(0.0)
    return whole


@inline_kernel
def assume_missing(pose, absences, bank, positions):
    """Set the points that are missing as a movement begins to where they are at the begin of the first example.

    They count as hidden until they are seen.

    Args:
        pose: (K, 3) m relative to the centre.
        absences: (K,) s.
        bank: `Bank`.
        positions: (J, 3) of the frame.

    Returns:
        Whether the centre is there: without it nothing can be followed.
    """
    if is_hidden(bank.points, 0, positions):
        return False
    assumed = first_pose(bank)
    for k in range(1, absences.size):
        if is_hidden(bank.points, k, positions):
            for d in range(3):
                pose[k, d] = assumed[k, d]
            absences[k] = np.float32(np.inf)
    return True


@inline_kernel
def note_absences(absences, bank, positions, whole, seconds):
    """Note for how long each point has been missing.

    Args:
        absences: (K,) s.
        bank: `Bank`.
        positions: (J, 3) of a frame.
        whole: Whether no point is missing in it.
        seconds: Since the frame before.
    """
    for k in range(absences.size):
        if whole or not is_hidden(bank.points, k, positions):
            absences[k] = np.float32(0.0)
        else:
            absences[k] += np.float32(seconds)


@inline_kernel
def keep_sample(line, hidden, known, bank):
    """Keep the directions of the sample that was taken, and which bones were hidden in it.

    Args:
        line: (B, 3) gets the directions.
        hidden: (B,) uint8.
        known: `Memory`.
        bank: `Bank`.
    """
    directions, absences, bones = known.directions, known.absences, bank.bones
    for b in range(bones.size):
        for d in range(3):
            line[b, d] = directions[b, d]
        hidden[b] = max(absences[bones[b].begin], absences[bones[b].end]) > LONGEST_HOLE


@kernel
def take_sample(known, bank, share, seconds):
    """Write the directions of bones between the last two frames, as of a body that faces the same way all the time.

    Args:
        known: `Memory`; the later frame is `poses[1]`.
        bank: `Bank`.
        share: Of the way from the earlier to the later frame, 0..1.
        seconds: Since the last sample, s.
    """
    state, poses, directions, bones = known.state[0], known.poses, known.directions, bank.bones
    later = np.float32(share)
    earlier = np.float32(1.0) - later
    cosine, sine = _facing(state, bank.head[0], poses[1], known.absences, seconds)
    for b in range(bones.size):
        begin, end = bones[b].begin, bones[b].end
        x = later * (poses[1, end, 0] - poses[1, begin, 0]) + earlier * (
            poses[0, end, 0] - poses[0, begin, 0]
        )
        y = later * (poses[1, end, 1] - poses[1, begin, 1]) + earlier * (
            poses[0, end, 1] - poses[0, begin, 1]
        )
        z = later * (poses[1, end, 2] - poses[1, begin, 2]) + earlier * (
            poses[0, end, 2] - poses[0, begin, 2]
        )
        length = np.sqrt(x * x + y * y + z * z)
        scale = np.float32(1.0) / max(length, SMALLEST)
        x, z = turned_back(x, z, cosine, sine)
        directions[b, 0] = scale * x
        directions[b, 1] = scale * y
        directions[b, 2] = scale * z


@inline_kernel
def _facing(state, head, pose, absences, seconds):
    """Let the facing follow hips and shoulders that are seen; return the cosine and the sine of the heading."""
    if head.left < 0:
        return np.float32(1.0), np.float32(0.0)
    girdles = (
        _seen(head.left, absences),
        _seen(head.right, absences),
        _seen(head.left_shoulder, absences),
        _seen(head.right_shoulder, absences),
    )
    x, z = facing_of(pose, girdles)
    share = 1.0 if state.samples == 0 else 1.0 - np.exp(-seconds / FACING_TIME)
    if x * x + z * z == 0.0:  # neither both hips nor both shoulders are seen
        share = 0.0
    state.facing[0] += share * (x - state.facing[0])
    state.facing[1] += share * (z - state.facing[1])
    cosine, sine = heading(state.facing[0], state.facing[1])
    return np.float32(cosine), np.float32(sine)


@inline_kernel
def _seen(point, absences):
    """Return a point of a girdle; -1 if it is hidden or there is none."""
    return point if point >= 0 and absences[point] <= LONGEST_HOLE else -1
