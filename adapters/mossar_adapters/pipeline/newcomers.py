"""Newcomers: how much that is new a live source may bring in a second, so that a stranger does not cost the others.

A new performer, and another skeleton of a known one, stop the thread that segments all performers: for 2 ms with 21 joints,
for 60 ms with 1,024 and limbs. Each is paid for by its joints, out of an allowance that fills with time. Performers who
stay as they are need none.
"""

AT_ONCE = 16_384  # joints: 15 of the largest skeletons, or 256 performers of 32 joints
A_SECOND = 1024.0  # joints: one of the largest skeletons, or 16 performers of 32 joints
EACH = 32  # joints that every newcomer counts for, besides its own


class Allowance:
    """What a source may still bring.

    Example:
        >>> allowance = Allowance()
        >>> sum(allowance.grants(1024, at) for at in [0.0] * 100), allowance.grants(1024, 0.4), allowance.grants(21, 0.4)
        (15, False, True)
    """

    def __init__(self) -> None:
        self._left = float(AT_ONCE)
        self._looked = float("-inf")  # s

    def grants(self, joints: int, now: float) -> bool:
        """Return whether something new may come, and take it off.

        Args:
            joints: Of the new skeleton, or performer.
            now: Monotonic s.
        """
        self._left = min(AT_ONCE, self._left + A_SECOND * max(0.0, now - self._looked))
        self._looked = max(self._looked, now)
        if joints + EACH > self._left:
            return False
        self._left -= joints + EACH
        return True
