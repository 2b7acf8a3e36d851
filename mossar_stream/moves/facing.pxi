"""Facing: the turn of a body about the vertical (y), by its hips and shoulders.

The girdles and the trunk span a frame of the body: left is from the right hips and shoulders to the left
ones, up is from the hips to the shoulders, forward is at right angles to both. The facing is the twist of that
frame about the vertical. A body that bows, ducks or does a cartwheel keeps it; the line of the hips alone turns
over in a cartwheel. A twist is undefined only for a body upside down; the vector shrinks
towards it, so that sums over time remain sound.
"""

cdef double SETTLING = 0.3  # s, time constant of a facing that is smoothed
cdef float LEAST_WIDTH = 1e-3  # m, of a girdle or a trunk: less has no direction
cdef float LEAST_FACING = 1e-6  # length of a facing: less is no direction


cdef (float, float) facing_of(FloatRows joints, const int64_t* girdles) noexcept nogil:
    """Return the way that a pose faces in the ground plane, not scaled to one.

    Args:
        joints: (J, 3) m, y up; NaN where a joint is missing.
        girdles: Four joints: left and right hip, left and right shoulder; -1 for none.

    Returns:
        x and z; (0, 1) for an upright body that faces +z, with its left side towards +x. The length is 1 for
        an upright body, less for a body that leans, and 0 if neither both hips nor both shoulders are there.
    """
    cdef float half, forward_x, forward_z, left_x, left_y, left_z, up_x, up_y, up_z
    cdef float hip_x, hip_y, hip_z, shoulder_x, shoulder_y, shoulder_z
    hip_x, hip_y, hip_z = _across(joints, girdles[0], girdles[1])
    shoulder_x, shoulder_y, shoulder_z = _across(joints, girdles[2], girdles[3])
    left_x, left_y, left_z = _unit(hip_x + shoulder_x, hip_y + shoulder_y, hip_z + shoulder_z)
    up_x, up_y, up_z = _trunk(joints, girdles)
    half = 0.5
    forward_x = left_y * up_z - left_z * up_y
    forward_z = left_x * up_y - left_y * up_x
    return half * (forward_x - left_z), half * (forward_z + left_x)


cdef inline (float, float, float) _across(FloatRows joints, int64_t left, int64_t right) noexcept nogil:
    """Return the way from the right joint of a girdle to the left one, m; zero if one is missing."""
    cdef float x, y, z
    if left < 0 or right < 0:
        return 0.0, 0.0, 0.0
    x = joints.at[3 * left] - joints.at[3 * right]
    y = joints.at[3 * left + 1] - joints.at[3 * right + 1]
    z = joints.at[3 * left + 2] - joints.at[3 * right + 2]
    if isnan(x + y + z):
        return 0.0, 0.0, 0.0
    return x, y, z


cdef inline (float, float, float) _trunk(FloatRows joints, const int64_t* girdles) noexcept nogil:
    """Return the unit direction from the hips to the shoulders; up if a girdle is missing."""
    cdef float x, y, z, sign
    cdef int64_t i, joint
    x = y = z = 0.0
    for i in range(4):
        sign = -1.0 if i < 2 else 1.0
        joint = girdles[i]
        if joint < 0:
            return 0.0, 1.0, 0.0
        x += sign * joints.at[3 * joint]
        y += sign * joints.at[3 * joint + 1]
        z += sign * joints.at[3 * joint + 2]
    x, y, z = _unit(x, y, z)
    if isnan(x + y + z) or x * x + y * y + z * z == 0.0:
        return 0.0, 1.0, 0.0
    return x, y, z


cdef inline (float, float, float) _unit(float x, float y, float z) noexcept nogil:
    cdef float length
    length = sqrtf(x * x + y * y + z * z)
    if length < LEAST_WIDTH:
        return 0.0, 0.0, 0.0
    return x / length, y / length, z / length


cdef inline void smooth_facing(double* held, float x, float z, double seconds) noexcept nogil:
    """Update a smoothed facing with that of one more pose; the time constant is `SETTLING`.

    Args:
        held: x and z of the smoothed facing; zeros before the first pose.
        x: Of `facing_of`; zero together with `z` where it is unknown: the facing stays.
        z: The same.
        seconds: Since the pose before.
    """
    cdef double share
    if x * x + z * z == 0.0:
        return
    if held[0] * held[0] + held[1] * held[1] == 0.0:
        held[0], held[1] = x, z
        return
    share = 1.0 - exp(-seconds / SETTLING)
    held[0] += share * (x - held[0])
    held[1] += share * (z - held[1])


cdef inline (double, double) heading(double x, double z) noexcept nogil:
    """Return the cosine and the sine of the turn from facing +z to facing (x, z); no turn if that is zero."""
    cdef double length
    length = sqrt(x * x + z * z)
    if length < LEAST_FACING:
        return 1.0, 0.0 * x
    return z / length, x / length


cdef inline (double, double) heading_in_floats(float x, float z) noexcept nogil:
    """Return the same as `heading`, computed in single precision."""
    cdef float length
    length = sqrtf(x * x + z * z)
    if length < LEAST_FACING:
        return 1.0, 0.0 * x
    return z / length, x / length


cdef inline (double, double) turned_back(double x, double z, double cosine, double sine) noexcept nogil:
    """Return a point (x, z) turned as if the body faced +z.

    Args:
        x: Of a point or a direction.
        z: The same.
        cosine: Of the body's `heading`.
        sine: The same.
    """
    return cosine * x - sine * z, sine * x + cosine * z


cdef inline (float, float) turned_back_in_floats(float x, float z, float cosine, float sine) noexcept nogil:
    """Return the same as `turned_back`, computed in single precision."""
    return cosine * x - sine * z, sine * x + cosine * z


cdef (double, double) mean_heading_of(FloatPlanes positions, const int64_t* girdles) noexcept nogil:
    """Return the cosine and the sine of a movement's mean heading; no turn where there are no hips.

    Args:
        positions: (n, J, 3) m.
        girdles: As for `facing_of`.
    """
    cdef float x, z, facing_x, facing_z
    cdef int64_t i
    x = z = 0.0
    if girdles[0] >= 0 and girdles[1] >= 0:
        for i in range(positions.planes):
            facing_x, facing_z = facing_of(plane_of_floats(positions, i), girdles)
            x += facing_x
            z += facing_z
    return heading_in_floats(x, z)
