"""What goes wrong outside while a stream runs."""

from mossar_stream.errors import MossarError


class OutputError(MossarError):
    """What was to be written could not be, as on a full disk; the stream goes on without that output."""
