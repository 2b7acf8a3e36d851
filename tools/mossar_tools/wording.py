"""Wording: how events of followed moves are put in words, in tables and terminals."""

from mossar_stream import FollowEvent


def counted(number: int, noun: str) -> str:
    """Return a number with its noun.

    Example:
        >>> counted(1, "repetition"), counted(0, "key frame")
        ('1 repetition', '0 key frames')
    """
    return f"{number} {noun}{'s' * (number != 1)}"


def strongest(kept: int, known: int) -> str:
    """Return a text about the kept key frames.

    Example:
        >>> strongest(6, 34), strongest(2, 2)
        ('the 6 strongest of 34 key frames', 'all 2 key frames')
    """
    return (
        f"all {counted(known, 'key frame')}"
        if kept == known
        else f"the {kept} strongest of {known} key frames"
    )


def straying(event: FollowEvent) -> str:
    """Return the limb that strays most, and its angle, as "left leg 12°"."""
    angle = event.limbs.get(event.limb, event.deviation)
    return f"{event.limb.replace('_', ' ')} {angle:.0f}°"


def judged(event: FollowEvent) -> str:
    """Return the numbers of a performance, as "tempo 1.12, deviation 8° (left leg 12°)"."""
    return f"tempo {event.tempo:.2f}, deviation {event.deviation:.0f}° ({straying(event)})"
