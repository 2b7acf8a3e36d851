"""A job between a socket and a subscriber, for tests: PORT SUBSCRIBER IDLE FORGET FOLDER."""

import sys
from pathlib import Path

from pyflink.common import Configuration
from pyflink.datastream import DataStream, StreamExecutionEnvironment

from mossar_adapters.flink.engine import build, options
from mossar_adapters.flink.job import Checkpoints, Job, Source, Takes, Target


def main(port, subscriber, idle, forget, folder):
    job = Job(
        source=Source(files="-"),
        to=Target(live=f"zmq://127.0.0.1:{subscriber}?encoding=json"),
        takes=Takes(idle=float(idle), forget=float(forget)),
        checkpoints=Checkpoints(folder=Path(folder, "checkpoints").as_uri()),
    )
    configuration = Configuration()
    for name, value in options(job).items():
        configuration.set_string(name, value)
    env = StreamExecutionEnvironment.get_execution_environment(configuration)
    stream = env._j_stream_execution_environment.socketTextStream("127.0.0.1", int(port))
    build(env, job, DataStream(stream))
    env.execute(job.name)


if __name__ == "__main__":
    main(*sys.argv[1:])
