"""Sources, sinks, file formats, sensors and engines around `mossar_stream`."""

import logging

# Programs decide what is said; until they do, nothing is.
logging.getLogger("mossar").addHandler(logging.NullHandler())
