"""Run every command of the documentation: `python -m checks.readme_commands`.

Fenced blocks of README.md, CONTRIBUTING.md and docs, and the examples of every `--help`, are run literally, each in a
folder of its own with files of the names they use. What does not end by itself is interrupted after some seconds, and
must then end as Ctrl-C ends it. Commands in running text are looked at: the command and its options must exist.
"""

import argparse
import math
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final, NamedTuple

from checks.fuzz import recordings
from mossar_tools.cli import COMMANDS, command_called, parser_of
from mossar_tools.errors import DONE, INTERRUPTED

ROOT = Path(__file__).parents[2]
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    *sorted(f"docs/{p.name}" for p in (ROOT / "docs").glob("*.md")),
)
PATIENCE = 6.0  # s until a command that goes on is interrupted
GOODBYE = 120.0  # s that it may take to end then; a busy machine may be compiling
FIRST = ("mossar demo --speed max --seconds 2", "mossar evaluate DIR")  # what has all kernels compiled
AT_ONCE = 3  # commands; most of them wait for something

COMMENT = re.compile(r"\s{2,}|\s+#\s")
PROGRAMS = ("mossar ", "python ", "python3 ", "pip ", "flink ", "eval ")  # nothing else is handed to a shell
NOT_RUN: Final[dict[str, str]] = {  # beginning of a command: why it is not run here
    "pip install": "installs; .ci/run does it in an environment of its own",
    "python3 -m venv": "makes an environment; .ci/run does it",
    "mossar flink": "needs an environment of its own: MOSSAR_ENGINES=1 .ci/run",
    "flink run": "needs a cluster",
    "mossar archive": "needs an environment of its own: MOSSAR_ENGINES=1 .ci/run",
    'python -c "import pandas': "reads what mossar archive wrote",
    "python -m checks.flink_load": "needs an environment of its own",
    "python -m checks.peer_settings": "needs the peers, in an environment of their own",
    "python -m checks.readme_commands": "runs already",
    "mossar bench DIR --peers": "needs the peers, in an environment of their own",
}
TURNS = " Zrotation Xrotation Yrotation\n"
BONES = {
    "Spine": 12,
    "Chest": 12,
    "Neck": 15,
    "Head": 9,
    "LeftUpperArm": 12,
    "LeftLowerArm": 27,
    "LeftHand": 25,
}
FAILS_HERE: Final[dict[str, str]] = {  # the same for commands that rightly end with status 1 here
    "mossar adapters --check osc://": "nobody sends",
    "mossar adapters --check oak:": "there is no camera",
}
STAGE = """
sources = ["osc://127.0.0.1:39539"]
stats = 5
"""
POSES = """
import json
print(json.dumps({"type": "meta", "names": ["hip", "hand"], "parents": [-1, 0]}))
for i in range(600):
    print(json.dumps({"type": "frame", "t": i / 60, "xyz": [[0, 1, 0], [0.01 * (i % 100), 1, 0.3]]}))
"""


class Command(NamedTuple):
    """A line that a reader may type.

    Args:
        place: Where it stands.
        line: As it stands there, without its comment.
    """

    place: str
    line: str


def main() -> int:
    """Run all commands, print how it went, and return 1 if one of them is not as it should be."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.readme_commands", description="Run what we promise."
    )
    parser.add_argument("--only", metavar="TEXT", default="", help="commands that contain this")
    given = parser.parse_args()
    wrong = [f"{place}: {problem}" for place, problem in wrong_mentions()]
    commands = [command for command in dict.fromkeys(all_commands()) if given.only in command.line]
    with tempfile.TemporaryDirectory() as name:
        stage = Stage(Path(name))
        # The first run compiles, so that the others need not.
        first = Stage(Path(name) / "first", 600.0)
        for line in FIRST:
            first.run(Command("", line))
        with ThreadPoolExecutor(AT_ONCE) as threads:
            for command, problem in zip(commands, threads.map(stage.run, commands), strict=True):
                print(
                    f"{command.place:<24} {command.line}\n{'':<24} {problem or 'as it should be'}", flush=True
                )
                if problem.startswith("WRONG"):
                    wrong.append(f"{command.place}: {command.line}: {problem}")
    for line in wrong:
        print(line, file=sys.stderr)
    print(f"{len(commands)} commands, {len(wrong)} wrong")
    return 1 if wrong else 0


def all_commands() -> Iterator[Command]:
    """Yield the commands of all pages and of every `--help`."""
    for page in PAGES:
        fenced, _ = parts_of((ROOT / page).read_text())
        yield from (Command(page, line) for block in fenced for line in _lines(block))
    for name in COMMANDS:
        block = command_called(name).EXAMPLES.splitlines()
        yield from (Command(f"mossar {name} --help", line) for line in _lines(block))


def parts_of(page: str) -> tuple[list[list[str]], str]:
    """Return the lines of each fenced block that names no language, and the running text."""
    blocks: list[list[str]] = []
    text: list[str] = []
    fence: str | None = None
    for line in page.splitlines():
        if line.startswith("```"):
            fence = line[3:] if fence is None else None
            if fence == "":
                blocks.append([])
        elif fence is None:
            text.append(line)
        elif fence == "":
            blocks[-1].append(line)
    return blocks, "\n".join(text)


def _lines(block: Sequence[str]) -> Iterator[str]:
    """Yield the commands of a block, without prompts, comments, and what is shown of their output."""
    prompted = any(line.startswith("$ ") for line in block)
    for line in block:
        if line.strip() and (line.startswith("$ ") or not prompted):
            yield COMMENT.split(line.strip().removeprefix("$ "))[0]


def _options(name: str) -> set[str]:
    """Return the options of a command."""
    parser = parser_of(f"mossar {name}", command_called(name))
    return {option for action in parser._actions for option in action.option_strings}  # noqa: SLF001


def wrong_mentions() -> Iterator[tuple[str, str]]:
    """Yield what running text says of commands and options that there are not."""
    options = {name: _options(name) for name in COMMANDS}
    for page in PAGES:
        _, text = parts_of((ROOT / page).read_text())
        for mention in re.findall(r"`mossar ([a-z][^`]*)`", text):
            name, *rest = mention.split()
            if name not in COMMANDS:
                yield page, f"`mossar {mention}`: there is no such command"
                continue
            for word in rest:
                if word.startswith("--") and word.partition("=")[0] not in options[name]:
                    yield page, f"`mossar {mention}`: there is no {word}"


class Stage:
    """Folders with what the commands name, and one command at a time for each port.

    Args:
        folder: Where they are made.
        patience: s until a command that goes on is interrupted.
    """

    def __init__(self, folder: Path, patience: float = PATIENCE) -> None:
        self._folder, self._patience, self._count = folder, patience, 0
        self._lock = threading.Lock()
        self._ports: dict[str, threading.Lock] = {}
        bin_ = folder / "bin"
        bin_.mkdir(parents=True)
        for name, module in {"mossar": "-m mossar_tools", "python": ""}.items():
            script = bin_ / name
            script.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} {module} "$@"\n')
            script.chmod(0o755)
        places = [ROOT, ROOT / "adapters", ROOT / "tools"]
        self.environment = {
            **os.environ,
            "PATH": f"{bin_}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": os.pathsep.join(map(str, places)),
            "BROWSER": "true",  # a program that does nothing
        }

    def run(self, command: Command) -> str:
        """Run a command and return what is to be said of it; it begins with WRONG where it is not as it should be."""
        if not f"{command.line} ".startswith(PROGRAMS):
            return "WRONG: no command; a block of something else names its language, as in ```text"
        for beginning, why in NOT_RUN.items():
            if command.line.startswith(beginning):
                return f"not run: {why}"
        missing = [
            word for word in ("jq", "oscdump") if word in command.line.split() and not shutil.which(word)
        ]
        if missing:
            return f"not run: {missing[0]} is not installed"
        with self._lock:
            self._count += 1
            folder = furnished(self._folder / str(self._count))
            if command.line.startswith("mossar replay take.msk"):
                (folder / "take.msk").write_bytes(recordings.msk(300))
            ports = [
                self._ports.setdefault(port, threading.Lock())
                for port in sorted(set(re.findall(r":(\d{4,5})\b", command.line)))
            ]
        for port in ports:
            port.acquire()
        try:
            return self._judged(command, folder)
        finally:
            for port in ports:
                port.release()

    def _judged(self, command: Command, folder: Path) -> str:
        with subprocess.Popen(  # noqa: S602 - that is the point: as a reader would type it
            command.line,
            shell=True,
            executable="/bin/bash",
            cwd=folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        ) as running:
            interrupted = False
            try:
                _, err = running.communicate(timeout=self._patience)
            except subprocess.TimeoutExpired:
                interrupted = True
                os.killpg(running.pid, signal.SIGINT)
                try:
                    _, err = running.communicate(timeout=GOODBYE)
                except subprocess.TimeoutExpired:
                    os.killpg(running.pid, signal.SIGKILL)
                    return "WRONG: Ctrl-C does not end it"
        return _verdict(command, running.returncode, err.decode(errors="replace"), interrupted=interrupted)


def _verdict(command: Command, status: int, err: str, *, interrupted: bool) -> str:
    said = err.strip().splitlines()
    problems = [line for line in said if "error" in line.lower()]
    if interrupted:
        ended = status in {DONE, INTERRUPTED, -signal.SIGINT, 128 + signal.SIGINT}
        return (
            "goes on until Ctrl-C"
            if ended and not problems
            else f"WRONG: status {status}: {_last(problems or said)}"
        )
    for beginning, why in FAILS_HERE.items():
        if command.line.startswith(beginning):
            return f"status 1, rightly: {why}" if status == 1 else f"WRONG: status {status}, though {why}"
    return "" if status == DONE and not problems else f"WRONG: status {status}: {_last(problems or said)}"


def _last(lines: Sequence[str]) -> str:
    return lines[-1] if lines else "nothing was said"


def furnished(folder: Path) -> Path:
    """Make a folder with all files that the documentation names, and return it."""
    labelled = [folder / name for name in ("DIR", "FOLDER", "DIR1", "DIR2", "DIR3")]
    for place in (folder, *labelled):
        place.mkdir(parents=True)
    contents = {
        "take.bvh": humanoid(300),
        "walk.bvh": humanoid(300),
        "86_01.amc": recordings.amc(300),
        "86.asf": recordings.ASF,
        "take.c3d": recordings.c3d(),
        "poses.py": POSES.encode(),
        "stage.toml": STAGE.encode(),
        "settings.toml": b"[settings]\nsig_threshold = 0.04\n",
    }
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    for place in labelled:
        (place / "walk.npz").write_bytes(recordings.npz(300))
        (place / "walk.json").write_text(
            '{"recording": "walk.npz", "fps": 30, "unit": "m", "cuts": [100, 200]}'
        )
    return folder


def humanoid(frames: int) -> bytes:
    """Return a BVH recording of a chain of bones that have names of a humanoid; it swings."""
    text = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition" + TURNS
    for name, length in BONES.items():
        text += f"JOINT {name}\n{{\nOFFSET 0 {length} 0\nCHANNELS 3{TURNS}"
    text += "End Site\n{\nOFFSET 0 10 0\n}\n" + "}\n" * (len(BONES) + 1)
    text += f"MOTION\nFrames: {frames}\nFrame Time: 0.0333333\n"
    for i in range(frames):
        angle = 40.0 * math.sin(i / 10) if i % 90 > 45 else 0.0
        text += f"0 90 0 0 0 0{f' 0 {angle:.3f} 0' * len(BONES)}\n"
    return text.encode()


if __name__ == "__main__":
    sys.exit(main())
