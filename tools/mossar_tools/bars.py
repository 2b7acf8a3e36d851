"""Bars of text."""

_EIGHTHS = " ▏▎▍▌▋▊▉█"


def bar(share: float, width: int, *, fine: bool) -> str:
    """Return a bar of `width` characters, of which `share` (0..1) is filled.

    Args:
        share: Limited to 0..1.
        width: Characters, without the frame.
        fine: Whether to use block characters; otherwise ASCII.

    Example:
        >>> bar(0.55, 4, fine=True), bar(0.55, 4, fine=False)
        ('▕██▎ ▏', '[##  ]')
    """
    share = min(max(share, 0.0), 1.0)
    if not fine:
        return f"[{'#' * round(share * width):<{width}}]"
    eighths = round(share * width * 8)
    full, rest = divmod(eighths, 8)
    filled = "█" * full + (_EIGHTHS[rest] if rest else "")
    return f"▕{filled:<{width}}▏"
