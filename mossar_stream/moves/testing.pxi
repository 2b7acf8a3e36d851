"""Kernels of recognised moves as tests call them."""


def facing(float[:, ::1] joints, int64_t[::1] girdles):
    return facing_of(floats_in_rows(&joints[0, 0], joints.shape[0], 3), &girdles[0])


def smoothed_facing(double[::1] held, double[:, ::1] found, double[::1] times):
    cdef int64_t i
    for i in range(times.shape[0]):
        smooth_facing(&held[0], found[i, 0], found[i, 1], times[i] - times[max(i - 1, 0)])


def brought_back(double x, double z, double facing_x, double facing_z):
    cdef double cosine, sine
    cosine, sine = heading(facing_x, facing_z)
    return turned_back(x, z, cosine, sine)
