"""Names of performers as they come from outside."""

import hashlib

from mossar_stream import MAX_PERFORMER_NAME, performer_name

_DIGEST = 4  # bytes
_MOST = 1 << 16  # characters of a name that count


def distinct_name(name: str) -> str:
    """Return a performer name; names too long to be kept whole stay different by a digest of the rest.

    Example:
        >>> distinct_name("ann")
        'ann'
        >>> distinct_name("a" * 100)[-12:], distinct_name("a" * 101)[-12:]
        ('aaa~7120fc31', 'aaa~9dae79c6')
    """
    if len(name) <= MAX_PERFORMER_NAME:
        return performer_name(name)
    digest = hashlib.blake2b(name[:_MOST].encode("utf-8", "replace"), digest_size=_DIGEST).hexdigest()
    return f"{performer_name(name)[: MAX_PERFORMER_NAME - len(digest) - 1]}~{digest}"
