"""Reader: what follows the frames of a performer besides the segmentation of body and limbs, and makes events of its own."""


cdef class Reader:
    """A compiled function with its state of one performer. The loop calls it with each frame of the body that is due.

    A further reader is a class like `MoveReader` of moves/out.pxi, and one of Python which prepares its state and its store,
    like `moves.recognition.Recognition`; `segmenter.followers` knows of it.

    Attributes:
        state: Bytes, never moved. The first eight are a float64, `due`: a frame from `due - BACK` until before `due`, s, brings
            nothing; -inf to see every frame.
        store: Bytes that the function needs besides; never moved, empty if there is nothing. Performers may share it.
    """

    cdef See see
    cdef public cnp.ndarray state
    cdef public cnp.ndarray store

    cdef Periods* hears(self):
        """Return the place in `state` where the loop keeps what is counted of the body's repetitions; NULL for nowhere."""
        return NULL

    cdef int report(self, int64_t take, double* origin, list pending) except -1:
        """Add the events of the last frame to what is pending.

        Args:
            take: Number of the take that is open.
            origin: (3,) m, from where the positions are counted.
            pending: Gets the events.
        """
        return 0

    cdef int end(self, int64_t take, list pending) except -1:
        """Forget what is going on, as a take ends; `pending` gets the events that this brings."""
        return 0

    cdef int afterwards(self) except -1:
        """Call what the caller gave to be called. It may raise, so it comes when all else is done."""
        return 0
