"""Range: what a velocity is a share of.

The paper normalises by the smallest and largest velocity of the whole file. A stream has no whole file, so the
range follows it: `running` takes the largest velocity so far and 0 (the curve starts at 0), `decay` lets that
largest velocity fade. Instead of rescaling history, the threshold grows with the range: curves, Ceiling and
Floor stay in metres and θ becomes θ · range. With `fixed` bounds (and `file`, which is `fixed` after a first
pass) the curve is normalised at once, as in the paper.
"""

import numpy as np

from mossar_stream.jit.decorators import kernel

POLICIES = ("running", "fixed", "decay")
RUNNING, FIXED, DECAY = range(3)


@kernel
def normalise(h, velocity, dt):
    """Return the velocity on the scale that θ is compared on, and what 1 is on that scale.

    Args:
        h: Header of the row; keeps the largest velocity.
        velocity: m over the window.
        dt: s since the last frame.

    Returns:
        (value, scale): a share of the range and 1 for `fixed`; metres and the range in metres otherwise.
    """
    if h.range_policy == FIXED:
        return (velocity - h.range_min) / (h.range_max - h.range_min), 1.0
    if h.range_policy == DECAY:
        h.largest *= np.exp2(-dt / h.range_half_life)
    h.largest = max(h.largest, velocity)
    # People who stand still must not flood: their noise is no motion.
    return velocity, max(h.largest, h.range_floor, h.noise_floor)
