"""Errors of the package, as one tree.

Misuse by the calling program raises `ValueError` or `TypeError`; the classes here are for data from outside:
settings written by users, frames sent by others, files and snapshots of unknown origin.
"""


class MossarError(Exception):
    """Root of every error that a user, a sender or a file can cause.

    Its text is one printable line, whichever names and words it quotes.
    """

    def __str__(self) -> str:
        text = super().__str__()
        return text if text.isprintable() else "".join(c if c.isprintable() else " " for c in text)


class SettingsError(MossarError, ValueError):
    """A setting has an unknown name or an illegal value; the message names field, value and legal range."""


class FrameError(MossarError, ValueError):
    """A frame cannot be used (wrong shape, too many joints); a live stream counts it and goes on."""


class MovesError(MossarError, ValueError):
    """An example, a move's name or a file of moves cannot be used; the message names it and the reason."""


class SnapshotError(MossarError, ValueError):
    """A snapshot is damaged, truncated, or written by a newer version."""
