"""`mossar flink`: live streams of many performers on Apache Flink."""

from pathlib import Path
from typing import Annotated

import msgspec

from mossar_tools.console import LOGGER, Console
from mossar_tools.declared import operand
from mossar_tools.errors import DONE, FAILED
from mossar_tools.options import Messages

DESCRIPTION = """Segment the streams of many performers on Apache Flink: records from a topic or from files, keyed by
performer; events to a topic, to files, or directly to a sink. A TOML file describes the job; docs/engines.md explains it."""
EXAMPLES = """  mossar flink job.toml                                          on this machine
  flink run -py .../mossar_tools/__main__.py flink job.toml      on a cluster
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    file: Annotated[str, operand("JOB.toml", "description of the job")]
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    del console
    from mossar_adapters.extras import needed
    from mossar_adapters.flink.engine import JobFailedError, latest_checkpoint, run
    from mossar_adapters.flink.job import read_job

    job = read_job(Path(options.file))
    if job.checkpoints.resume and (latest := latest_checkpoint(job.checkpoints.folder)) is not None:
        LOGGER.info("going on from the checkpoint in %s", latest)
    needed("pyflink", "flink", "mossar flink")
    LOGGER.info("starting Flink, which takes a minute or more; then it runs until its source ends, or Ctrl-C")
    try:
        run(job)
    except JobFailedError as error:
        LOGGER.error("%s", error)
        return FAILED
    return DONE
