"""Engine: builds the job and runs it, here or on the cluster that `flink run` names."""

import contextlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote, urlsplit

from mossar_adapters.extras import needed
from mossar_adapters.flink.job import Job
from mossar_stream import MossarError

if TYPE_CHECKING:
    from pyflink.datastream import DataStream, StreamExecutionEnvironment

MAX_PARALLELISM = 1024  # cannot be changed once there are checkpoints
JAVA_NEEDED = 11
ENDED = "ended"  # file beside the checkpoints of a run that has come to its end


class JobFailedError(MossarError):
    """The job ended otherwise than by coming to the end of its source."""


def run(job: Job) -> None:
    """Run a job until its source ends.

    Args:
        job: The job.

    Raises:
        MossarError: If Flink, Java or the Kafka connector is missing.
        JobFailedError: If the job fails.
    """
    needed("pyflink", "flink", "mossar flink")
    on_cluster = "PYFLINK_GATEWAY_PORT" in os.environ  # set by `flink run`
    if not on_cluster:
        check_java()
    from py4j.protocol import Py4JJavaError
    from pyflink.common import Configuration
    from pyflink.datastream import StreamExecutionEnvironment

    configuration = Configuration()
    for name, value in options(job, on_cluster=on_cluster).items():
        configuration.set_string(name, value)
    env = StreamExecutionEnvironment.get_execution_environment(configuration)
    build(env, job)
    former = runs_cut_short(job.checkpoints.folder) if job.checkpoints.resume else []
    try:
        result = env.execute(job.name)
    except Py4JJavaError as error:
        cause = _cause(str(error.java_exception), str(error))
        raise JobFailedError(f"the Flink job failed: {cause}") from None
    try:
        result.get_net_runtime()
    except Py4JJavaError:  # it was handed over to a cluster (flink run --detached), and goes on there
        return
    leave_nothing(job.checkpoints.folder, str(result.get_job_id()), *former)


def build(env: "StreamExecutionEnvironment", job: Job, records: "DataStream | None" = None) -> None:
    """Lay the stream: records, keyed by performer, segmented, sent.

    Args:
        env: Environment of the engine.
        job: The job.
        records: Instead of the job's source.
    """
    from pyflink.common import Types

    from mossar_adapters.flink import ends
    from mossar_adapters.flink.function import SegmentFunction
    from mossar_adapters.flink.records import performer_of

    stream = ends.records(env, job.source) if records is None else records
    keyed = stream.key_by(performer_of, Types.STRING())
    moves = job.segmenter.read_moves()
    function = SegmentFunction(job.segmenter.build(), job.takes, moves, job.segmenter.followed(moves))
    # With a name of its own the state is found again after other changes of the job.
    events = keyed.process(function, Types.STRING()).name("segment").uid("segment")
    ends.send(events, job.to, job.name)


def options(job: Job, *, on_cluster: bool = False) -> dict[str, str]:
    """Return the engine's options; those of the job's table [flink] come last and win."""
    chosen = {
        # One process for Java and Python: 2 ms instead of 80 from record to event.
        "python.execution-mode": "thread",
        "parallelism.default": str(job.parallelism),
        "pipeline.max-parallelism": str(MAX_PARALLELISM),
        "execution.buffer-timeout.interval": "1 ms",
        "execution.checkpointing.dir": job.checkpoints.folder,
        "execution.checkpointing.interval": f"{round(job.checkpoints.seconds * 1000)} ms",
        "execution.checkpointing.externalized-checkpoint-retention": "RETAIN_ON_CANCELLATION",
    }
    if not on_cluster:
        # At a terminal a failure is reported soon; a cluster has its own restart strategy.
        chosen["restart-strategy.type"] = "fixed-delay"
        chosen["restart-strategy.fixed-delay.attempts"] = "3"
        chosen["restart-strategy.fixed-delay.delay"] = "1 s"
        chosen["python.executable"] = sys.executable
        # The embedded interpreter does not know of virtual environments.
        chosen["python.pythonpath"] = os.pathsep.join(path for path in sys.path if path)
    latest = latest_checkpoint(job.checkpoints.folder) if job.checkpoints.resume else None
    if latest is not None:
        chosen["execution.state-recovery.path"] = latest.as_uri()
        chosen["execution.state-recovery.claim-mode"] = "CLAIM"
    given = {
        name: str(value).lower() if isinstance(value, bool) else str(value)
        for name, value in job.flink.items()
    }
    return {**chosen, **given}


def latest_checkpoint(folder: str) -> Path | None:
    """Return the last whole checkpoint in a local folder, of a run that has not come to its end.

    Args:
        folder: URI. For a bucket, "execution.state-recovery.path" names the checkpoint instead.
    """
    times = _whole_checkpoints(folder)
    return max(times, key=times.__getitem__) if times else None


def runs_cut_short(folder: str) -> list[str]:
    """Return the engine's ids of the runs from which a run may go on: the last one, and those before that were killed, too.

    A run that was killed twice leaves checkpoints of each. When its last part has ended, nothing is left to do for any.

    Args:
        folder: URI, as for `latest_checkpoint`.
    """
    return sorted({checkpoint.parent.name for checkpoint in _whole_checkpoints(folder)})


def _whole_checkpoints(folder: str) -> dict[Path, int]:
    """Return the whole checkpoints of runs that have not come to their end, and when they were written, ns."""
    parts = urlsplit(folder)
    times: dict[Path, int] = {}
    if parts.scheme != "file":
        return times
    # The engine writes this file last.
    for path in Path(unquote(parts.path)).glob("*/chk-*/_metadata"):
        with contextlib.suppress(FileNotFoundError):  # the engine has just removed it
            if not (path.parents[1] / ENDED).exists():
                times[path.parent] = path.stat().st_mtime_ns
    return times


def leave_nothing(folder: str, *runs: str) -> None:
    """See that no later run goes on from checkpoints of runs that have come to their end.

    The engine removes them in threads of its own: when it reports the end of the job, the last checkpoint may not be removed
    yet, or not even be written. The process may end before that. Each run is therefore marked as ended, whatever files are left of it.

    Args:
        folder: URI of the checkpoints; those in a bucket are named by the user, and left to the engine.
        runs: The engine's ids of the runs.

    Raises:
        MossarError: If that cannot be written.
    """
    parts = urlsplit(folder)
    if parts.scheme != "file":
        return
    for run_id in runs:
        place = Path(unquote(parts.path), run_id)
        try:
            place.mkdir(parents=True, exist_ok=True)
            (place / ENDED).touch()
        except OSError as error:
            raise MossarError(
                f"{place}: cannot be written: {error.strerror or error}; delete it, or the next run continues from it"
            ) from None
        for checkpoint in place.glob("chk-*"):
            shutil.rmtree(checkpoint, ignore_errors=True)


def check_java() -> None:
    """Check that there is a Java that Flink can use.

    Raises:
        MossarError: If there is none, or it is too old.
    """
    home = os.environ.get("JAVA_HOME")
    java = str(Path(home, "bin", "java")) if home else "java"
    advice = "install Java 17 (apt-get install openjdk-17-jre-headless), or let JAVA_HOME name it"
    if shutil.which(java) is None:
        raise MossarError(f"mossar flink needs Java, and there is no {java}: {advice}")
    answer = subprocess.run([java, "-version"], capture_output=True, text=True, check=False)  # noqa: S603
    version = re.search(r'version "(\d+)', answer.stderr)
    if version is None or int(version[1]) < JAVA_NEEDED:
        raise MossarError(
            f"mossar flink needs Java {JAVA_NEEDED} or 17, not {answer.stderr[:40]!r}: {advice}"
        )


def _cause(short: str, long: str) -> str:
    """Return the innermost cause in a Java stack trace, as one line."""
    causes = re.findall(r"^Caused by: (.+)$", long, re.MULTILINE)
    text = " ".join((causes[-1] if causes else short).split())
    return re.sub(r"^pemja\.core\.PythonException: <class '[^']*'>: ", "", text)[:400]
