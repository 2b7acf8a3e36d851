"""Candidate features: what is known of a candidate for evidence, from where it is found until its key frame is confirmed.

Features of single frames are noted in `note_speed`, those of the candidate's frame in `note_place`; `features_of` puts them
together, in the units of the performer's own scales.
"""

import numpy as np

from mossar_stream.algorithm.noise import noise_level
from mossar_stream.algorithm.pose_history import MARGIN, SPEED_WINDOW, mark_at
from mossar_stream.algorithm.scales import extent, rest_distance, tempo_of, usual_speed
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.similarity.evidence import Features

SMOOTHING = 0.05  # s, time constant of the poses' low-pass filter
EARLIER = 0.06  # s; what velocity and low-pass filter show happened so long ago
EARLIER_IN_NOISE = 0.12  # s, the same while noise is loud, when the velocity is that of the filtered poses
SPEED_SETTLING = 0.1  # s at the start of a take, in which the filter settles and noise is not known
# Refractory period, s, between key frames that are reported when Algorithm 2 accepts them; the shorter one if the later one is slow
INTERVAL, SHORT_INTERVAL = 0.36, 0.25
RISEN = 1.2  # times the speed at the key frame that the speed must have reached before
QUICK = 3.0  # V; a faster performer is in the midst of a move
REPORTED_ABOVE_NOISE = 2.5  # times the sensor's noise that a speed must have reached before

NOT_PLACED = np.int64(-1)

CANDIDATE = np.dtype(
    [
        # Reported frame: `EARLIER` than Algorithm 2's frame; NOT_PLACED if nothing was seen there.
        ("frame", "i8"),
        ("time", "f8"),  # s
        ("speed", "f8"),  # m/s, lowest since the candidate
        ("rest_distance", "f8"),  # m, distance from the pose in which the performer dwells
        ("peak", "f8"),  # m/s, largest since the last reported key frame
        ("before", "i8"),  # reported frame of the key frame before
        ("reported_time", "f8"),  # s, of the last reported key frame
        ("reported_speed", "f8"),  # m/s, lowest speed at that one
    ],
)


@kernel
def start_candidate(candidate, frame, time):
    """Begin a take."""
    candidate.frame = frame
    candidate.time = time
    candidate.speed = 0.0
    candidate.rest_distance = 0.0
    candidate.peak = 0.0
    candidate.before = frame
    candidate.reported_time = time + SPEED_SETTLING
    candidate.reported_speed = 0.0


@inline_kernel
def smoothing_weights(dt):
    """Return what is left of the filtered pose, and the weight of the newest displacement.

    The filter is a first-order low-pass, exact for straight lines between the poses: it is late by SMOOTHING at any rate.
    """
    if dt <= 0.0:
        return np.float32(1.0), np.float32(0.0)
    kept = np.exp(-dt / SMOOTHING)
    return np.float32(kept), np.float32(kept - (1.0 - kept) * SMOOTHING / dt)


@kernel
def note_place(candidate, scales, history, body, time, joints):
    """Note what is known of a candidate, or of a crossing, at the last frame.

    Args:
        candidate: CANDIDATE.
        scales: SCALES.
        history: PoseHistory.
        body: See joint_pages.py; the features are those of the last frame.
        time: s, reported time of the key frame.
        joints: How many can move relative to the centre.
    """
    candidate.speed = scales.speed
    candidate.rest_distance = rest_distance(body, joints)
    place = mark_at(history, time)
    if place >= 0:
        candidate.frame = history.marks[place].frame
        candidate.time = history.marks[place].time


@inline_kernel
def note_speed(candidate, scales, time):
    """Note the speed of a frame, unless a key frame was reported just now."""
    if time > candidate.reported_time + MARGIN:
        candidate.peak = max(candidate.peak, scales.speed)


@inline_kernel
def noise_of_speed(noise, joints):
    """Return what the sensor's noise adds to the speed of the filtered poses, m/s.

    White noise takes each joint √6 σ a frame; filtered with weight a, and over the speed window, it takes it
    √(6 a / (2 - a)) σ.
    """
    if noise.step <= 0.0:
        return 0.0
    share = noise.step / (noise.step + SMOOTHING)
    return noise_level(noise) / joints * noise.step * np.sqrt(share / (2.0 - share)) / SPEED_WINDOW


@kernel
def features_of(candidate, scales, noise, joints):
    """Return `Features` of a key frame that is confirmed; `noise` in m/s, `joints` is how many can move."""
    size = extent(scales)
    return Features(
        candidate.speed,
        candidate.rest_distance / size,
        size,
        usual_speed(scales),
        tempo_of(scales),
        noise,
        joints,
    )


@inline_kernel
def is_reported(candidate, scales, time, noise):
    """Tell whether a key frame is reported at once: slow, apart from the last one, and not the sensor's noise.

    Within the refractory period a slower minimum is still reported: the first may have been a brief pause.
    """
    slow = candidate.speed <= QUICK * usual_speed(scales)
    rose = candidate.peak >= max(REPORTED_ABOVE_NOISE * noise, RISEN * candidate.speed)
    interval = SHORT_INTERVAL if candidate.speed <= RISEN * candidate.reported_speed else INTERVAL
    return slow and rose and time - candidate.reported_time >= interval - MARGIN
