"""Normalisation: the range that a velocity is a share of.

The paper normalises by the smallest and largest velocity of the whole file. A stream has no whole file, so the
range follows it: `running` takes the largest velocity so far and 0 (the curve starts at 0), `decay` lets that
largest velocity fade. Instead of rescaling history, the threshold grows with the range: curves, Ceiling and
Floor stay in metres and θ becomes θ · range. With `fixed` bounds (and `file`, which is `fixed` after a first
pass) the curve is normalised at once, as in the paper.
"""

cdef enum:
    RANGE_IS_FIXED = 1
    RANGE_DECAYS = 2

cdef struct Range:
    double largest  # m, velocity so far; it outlasts a take


cdef (double, double) normalise(
    Range* velocity_range, Plan* plan, double noise_floor, double velocity, double dt
) noexcept nogil:
    """Return the velocity on the scale on which θ is compared, and the value of 1 on that scale.

    Args:
        velocity_range: RANGE.
        plan: PLAN.
        noise_floor: m, below which the range does not fall because of the sensor's noise.
        velocity: m over the window.
        dt: s since the last frame.

    Returns:
        (value, scale): a share of the range and 1 for `fixed`; metres and the range in metres otherwise.
    """
    if plan.range_policy == RANGE_IS_FIXED:
        return ((velocity - plan.range_min) / (plan.range_max - plan.range_min), 1.0)
    if plan.range_policy == RANGE_DECAYS:
        velocity_range.largest *= exp2(-dt / plan.range_half_life)
    velocity_range.largest = max(velocity_range.largest, velocity)
    # A person who stands still must cause no flood of key frames: noise is no motion.
    return velocity, max(velocity_range.largest, plan.range_floor, noise_floor)
