"""Sources, sinks, file formats, sensors and engines around `mossar_stream`."""

import logging

# Programs configure the log; until they do, nothing is logged.
logging.getLogger("mossar").addHandler(logging.NullHandler())
