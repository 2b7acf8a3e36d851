"""Facing: which way a body is turned about the vertical (y), by its hips and shoulders.

The girdles and the trunk span a frame of the body: left is from the right hips and shoulders to the left ones, up is from
the hips to the shoulders, forward is what both span. The facing is the twist of that frame about the vertical. A body
that bows, ducks or does a cartwheel keeps it, which the line of the hips alone does not: it turns over in a cartwheel.
A twist is undefined only for a body upside down; the vector shrinks towards it, so that sums over time remain sound.
"""

# CHECK tuple GIRDLES = ('left_hip', 'right_hip', 'left_shoulder', 'right_shoulder')
cdef double SETTLING = 0.3  # s, time constant of a facing that is smoothed
cdef float LEAST_WIDTH = 0.0010000000474974513  # m, of a girdle or a trunk: less has no direction


cdef (float, float) facing_of(FloatRows joints, Ints girdles) noexcept nogil:
    """Return the way that a pose faces in the ground plane, not scaled to one.

    Args:
        joints: (J, 3) float32 metres, y up; NaN where a joint is missing.
        girdles: (4,) from `girdles_of`.

    Returns:
        x and z; (0, 1) for an upright body that faces +z, with its left side towards +x. The length is 1 for an upright
        body, less for a body that leans, and 0 if neither both hips nor both shoulders are there.
    """
    cdef float half, forward_x, forward_z, hip_x, hip_y, hip_z, shoulder_x, shoulder_y, shoulder_z, left_x, left_y, left_z, up_x, up_y, up_z
    # CHECK _trunk is called with several kinds of arguments
    hip_x, hip_y, hip_z = _across(joints, girdles.at[0], girdles.at[1])
    shoulder_x, shoulder_y, shoulder_z = _across(joints, girdles.at[2], girdles.at[3])
    left_x, left_y, left_z = _unit(hip_x + shoulder_x, hip_y + shoulder_y, hip_z + shoulder_z)
    up_x, up_y, up_z = _trunk(joints, girdles)
    half = <float>0.5
    forward_x = left_y * up_z - left_z * up_y
    forward_z = left_x * up_y - left_y * up_x
    return half * (forward_x - left_z), half * (forward_z + left_x)


cdef inline (float, float, float) _across(FloatRows joints, int64_t left, int64_t right) noexcept nogil:
    """Return the way from the right joint of a girdle to the left one, m; zero if one is missing."""
    cdef float x, y, z
    if left < 0 or right < 0:
        return (<float>0.0, <float>0.0, <float>0.0)
    x = joints.at[left * joints.columns + 0] - joints.at[right * joints.columns + 0]
    y = joints.at[left * joints.columns + 1] - joints.at[right * joints.columns + 1]
    z = joints.at[left * joints.columns + 2] - joints.at[right * joints.columns + 2]
    if isnan(x + y + z):
        return (<float>0.0, <float>0.0, <float>0.0)
    return x, y, z


cdef inline (float, float, float) _trunk(FloatRows joints, Ints girdles) noexcept nogil:
    """Return the unit direction from the hips to the shoulders; up if a girdle is missing."""
    cdef float x, y, z, sign
    cdef int64_t i, joint
    x = y = z = <float>0.0
    for i in range(4):
        sign = <float>(-1.0) if i < 2 else <float>1.0
        joint = girdles.at[i]
        if joint < 0:
            return (<float>0.0, <float>1.0, <float>0.0)
        x += sign * joints.at[joint * joints.columns + 0]
        y += sign * joints.at[joint * joints.columns + 1]
        z += sign * joints.at[joint * joints.columns + 2]
    x, y, z = _unit(x, y, z)
    if isnan(x + y + z) or x * x + y * y + z * z == 0.0:
        return (<float>0.0, <float>1.0, <float>0.0)
    return x, y, z


cdef inline (float, float, float) _unit(float x, float y, float z) noexcept nogil:
    cdef float length
    length = sqrtf(x * x + y * y + z * z)
    if length < LEAST_WIDTH:
        return (<float>0.0, <float>0.0, <float>0.0)
    return x / length, y / length, z / length


cdef inline void smooth_facing(Doubles held, float x, float z, double seconds) noexcept nogil:
    """Let a facing follow that of one more pose, with the time constant `SETTLING`.

    Args:
        held: (2,) float64, x and z of the smoothed facing; zeros before the first pose.
        x: Of `facing_of`; zero together with `z` where it is unknown: the facing stays.
        z: The same.
        seconds: Since the pose before.
    """
    cdef double share
    if x * x + z * z == 0.0:
        return
    if held.at[0] * held.at[0] + held.at[1] * held.at[1] == 0.0:
        held.at[0], held.at[1] = x, z
        return
    share = 1.0 - exp(-seconds / SETTLING)
    held.at[0] += share * (x - held.at[0])
    held.at[1] += share * (z - held.at[1])


cdef inline (double, double) heading(float x, float z) noexcept nogil:
    """Return the cosine and the sine of the turn from facing +z to facing (x, z); no turn if that is zero."""
    cdef float length
    length = sqrtf(x * x + z * z)
    if length < <float>1e-6:
        return (<double>x * 0 + 1, <double>x * 0)
    return z / length, x / length


cdef inline (double, double) turned_back(float x, float z, double cosine, double sine) noexcept nogil:
    """Return where a point (x, z) would be if the body faced +z.

    Args:
        x: Of a point or a direction.
        z: The same.
        cosine: Of the body's `heading`.
        sine: The same.
    """
    return cosine * x - sine * z, sine * x + cosine * z


# ENTRY: called from Python
cdef (double, double) mean_heading(FloatPlanes positions, Ints girdles) noexcept nogil:
    """Return the cosine and the sine of a movement's mean heading; no turn where there are no hips.

    Args:
        positions: (n, J, 3) float32 metres.
        girdles: (4,) from `girdles_of`.
    """
    cdef float x, z, facing_x, facing_z
    cdef int64_t i
    cdef double cosine, sine
    # CHECK facing_of is called with several kinds of arguments
    # CHECK heading is called with several kinds of arguments
    x = z = <float>0.0
    if girdles.at[0] >= 0 and girdles.at[1] >= 0:
        for i in range(positions.planes):
            facing_x, facing_z = facing_of(plane_of_floats(positions, i), girdles)
            x += facing_x
            z += facing_z
    cosine, sine = heading(x, z)
    return cosine, sine
