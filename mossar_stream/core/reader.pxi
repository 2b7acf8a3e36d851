"""Reader: a follower of a performer's frames, beside the segmentation, with events of its own."""


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
        """Append the events of the last frame to the pending ones.

        Args:
            take: Number of the take that is open.
            origin: (3,) m, from where the positions are counted.
            pending: Gets the events.
        """
        return 0

    cdef int end(self, int64_t take, list pending) except -1:
        """Forget the state of a take as it ends; `pending` gets the events that this causes."""
        return 0

    cdef int afterwards(self) except -1:
        """Call the caller's own function. It may raise, so it comes last."""
        return 0
