"""Errors that end a program with another status than 0."""

from mossar_stream import MossarError

DONE, FAILED, WRONG_USAGE, INTERRUPTED, TERMINATED = 0, 1, 2, 130, 143  # exit statuses


class UsageError(MossarError):
    """The command line or the configuration is not valid; status 2."""


class Terminated(BaseException):
    """SIGTERM came; status 143."""
