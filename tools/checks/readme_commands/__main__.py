"""The program: `python -m checks.readme_commands`.

Fenced blocks of README.md, CONTRIBUTING.md, SECURITY.md and docs, and the examples of every `--help`, are run literally,
each in a folder of its own with files of the names they use. Commands that go on are interrupted after some seconds and
must then end as Ctrl-C ends them; all others must end by themselves, with status 0. The commands and programs of a tutorial run
one after another in one folder. Commands and options that running text mentions must exist.
"""

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from checks.readme_commands.commands import Command, all_commands, wrong_mentions
from checks.readme_commands.stage import GOES_ON, Stage

WAITING = 4  # commands at once that go on; most of them wait for something


def main() -> int:
    """Run all commands, print how it went, and return 1 if one of them is not as it should be."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.readme_commands", description="Run the commands of the documentation."
    )
    parser.add_argument("--only", metavar="TEXT", default="", help="commands that contain this")
    given = parser.parse_args()
    wrong = [f"{place}: {problem}" for place, problem in wrong_mentions()]
    commands = [command for command in all_commands() if given.only in command.line]
    with tempfile.TemporaryDirectory() as name:
        stage = Stage(Path(name) / "stage")
        for command, (problem, seconds) in _all_run(stage, commands):
            print(
                f"{command.line}\n    {problem or 'as it should be'} ({seconds:.1f} s; {command.place})",
                flush=True,
            )
            if problem.startswith("WRONG"):
                wrong.append(f"{command.place}: {command.line}: {problem}")
    for line in wrong:
        print(line, file=sys.stderr)
    print(f"{len(commands)} commands, {len(wrong)} wrong")
    return 1 if wrong else 0


def _all_run(stage: Stage, commands: list[Command]) -> Iterator[tuple[Command, tuple[str, float]]]:
    """Run commands, those that go on beside those that compute, and yield the report of each."""
    computing, waiting = ThreadPoolExecutor(os.cpu_count()), ThreadPoolExecutor(WAITING)

    before: dict[str, Future[tuple[str, float]]] = {}  # the last command of each series

    def run(command: Command, earlier: Future[tuple[str, float]] | None) -> tuple[str, float]:
        if earlier is not None:
            earlier.result()
        began = time.monotonic()
        return stage.run(command), time.monotonic() - began

    try:
        futures: list[Future[tuple[str, float]]] = []
        for command in commands:
            pool = waiting if GOES_ON.search(command.line) else computing
            futures.append(pool.submit(run, command, before.get(command.series)))
            if command.series:
                before[command.series] = futures[-1]
        for command, future in zip(commands, futures, strict=True):
            yield command, future.result()
    finally:
        for pool in (computing, waiting):
            pool.shutdown(cancel_futures=True)


if __name__ == "__main__":
    sys.exit(main())
