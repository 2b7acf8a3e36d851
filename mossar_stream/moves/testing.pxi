"""Kernels of recognised moves for tests."""


def facing(cnp.ndarray joints, cnp.ndarray girdles, /):
    return facing_of(
        floats_in_rows(<float*>cnp.PyArray_DATA(joints), cnp.PyArray_DIM(joints, 0), 3),
        <int64_t*>cnp.PyArray_DATA(girdles),
    )


def smoothed_facing(cnp.ndarray held, cnp.ndarray found, cnp.ndarray times, /):
    cdef double* at = <double*>cnp.PyArray_DATA(times)
    cdef double* pair = <double*>cnp.PyArray_DATA(found)
    cdef int64_t i
    for i in range(cnp.PyArray_DIM(times, 0)):
        smooth_facing(<double*>cnp.PyArray_DATA(held), pair[2 * i], pair[2 * i + 1], at[i] - at[max(i - 1, 0)])


def brought_back(double x, double z, double facing_x, double facing_z, /):
    cdef double cosine, sine
    cosine, sine = heading(facing_x, facing_z)
    return turned_back(x, z, cosine, sine)
