"""Newcomers: the rate of new performers that a live source may bring, so that a stranger does not cost the others.

A new performer, and another skeleton of a known one, stop the thread that segments all performers: for 3 ms with 21 joints,
for 20 ms with 1,024 and limbs. Each is paid for by its joints, out of an allowance that fills with time. Joints beyond
those of a person are paid for out of a second one that holds less: a crowd begins at once, while large skeletons begin one
after another, with time for the other performers in between. Performers that do not change need none.
"""

AT_ONCE = 16_384  # joints: 256 performers of 32 joints
A_SECOND = 1024.0  # joints: 16 performers of 32 joints
EACH = 32  # joints that every newcomer counts for, besides its own
ORDINARY = 128  # joints of a person, with fingers or as a set of markers
LARGE_AT_ONCE = 2_048  # joints beyond the ordinary: two of the largest skeletons, or 11 of 300 markers
LARGE_A_SECOND = 448.0  # one of the largest skeletons in two seconds


class Allowance:
    """New skeletons that a source may still begin.

    Example:
        >>> allowance = Allowance()
        >>> sum(allowance.grants(1024, at) for at in [0.0] * 100), allowance.grants(1024, 0.4), allowance.grants(21, 0.4)
        (2, False, True)
    """

    def __init__(self) -> None:
        self._left = float(AT_ONCE)
        self._large_left = float(LARGE_AT_ONCE)
        self._looked = float("-inf")  # s

    def grants(self, joints: int, now: float) -> bool:
        """Return whether something new may come, and take it off.

        Args:
            joints: Of the new skeleton, or performer.
            now: Monotonic s.
        """
        since = max(0.0, now - self._looked)
        self._left = min(AT_ONCE, self._left + A_SECOND * since)
        self._large_left = min(LARGE_AT_ONCE, self._large_left + LARGE_A_SECOND * since)
        self._looked = max(self._looked, now)
        cost, large = joints + EACH, max(0, joints - ORDINARY)
        if cost > self._left or large > self._large_left:
            return False
        self._left -= cost
        self._large_left -= large
        return True
