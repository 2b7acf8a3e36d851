"""Stage: commands are run literally, those that wait beside those that compute, and judged."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from checks.readme_commands.commands import ROOT, Command
from checks.readme_commands.files import furnish
from mossar_tools.errors import DONE, INTERRUPTED

PATIENCE = 4.0  # s until a command that goes on is interrupted
LIMIT = 300.0  # s in which one that ends by itself must have ended, on a machine that is busy
TRIES = 3  # of a command whose port is in use
GOODBYE = 20.0  # s that it may take to end after Ctrl-C, on a machine that is busy

PROGRAMS = ("mossar ", "python ", "python3 ", "pip ", "flink ", "eval ")  # nothing else is handed to a shell
# Streams of others, the dashboard, endless shows, and commands of minutes.
GOES_ON = re.compile(
    r"mossar (run|record|teach|replay|view)\b.*\b(osc|zmq\S*)://|mossar run \d|mossar run --config|mossar view|mossar demo\b(?!.*head)"
    r"|mossar bench|mossar evaluate ('?demo:|.*--leave-out)|python -m checks|python examples/"
)
# Beginning of a command: why it is not run here.
NOT_RUN: Final[dict[str, str]] = {
    "pip install": "installs; .ci/run does it in an environment of its own",
    "python3 -m venv": "makes an environment; .ci/run does it",
    "mossar flink": "needs an environment of its own: MOSSAR_ENGINES=1 .ci/run",
    "flink run": "needs a cluster",
    "mossar archive": "needs an environment of its own: MOSSAR_ENGINES=1 .ci/run",
    'python -c "import pandas': "reads what mossar archive wrote",
    "python -m checks.flink_load": "needs an environment of its own",
    "python -m checks.peer_settings": "needs the peers, in an environment of their own",
    "python -m checks.readme_commands": "runs already",
    "mossar tune take.c3d --labels take.events.c3d": "reads what the command before it wrote; tests do",
    "mossar run webcam:": "there is no camera",
    "mossar view webcam:": "there is no camera",
    "mossar view oak:": "there is no camera",
    "mossar webcam": "serves a page until it is stopped",
    "mossar adapters --get-model": "fetches weights",
    "mossar segment dance.mp4": "there is no video with a person; tests make one",
    "mossar teach moves.json dance.mp4": "there is no video with a person; tests make one",
    "python -m checks.webcam": "needs a video with a person",
    "mossar teach moves.json --name jab_left --mirrored": "needs a body with two arms; tests do",
    "python -m checks.sides": "needs sessions of moves on command; tests make one",
    "mossar evaluate DIR --strict": "needs sessions of moves on command; tests make one",
    "python -m checks.peers DIR": "needs the peers, in an environment of their own",
}
# The same for commands that rightly end with status 1 here.
FAILS_HERE: Final[dict[str, str]] = {
    "mossar adapters --check osc://": "nobody sends",
    "mossar adapters --check oak:": "there is no camera",
    "mossar adapters --check webcam:": "there is no camera",
}


class Stage:
    """Folders with the files of the commands, and one command at a time for each port.

    Args:
        folder: Where they are made.
        patience: s until a command that goes on is interrupted.
        limit: s in which other commands must have ended.
    """

    def __init__(self, folder: Path, patience: float = PATIENCE, limit: float = LIMIT) -> None:
        self._folder, self._patience, self._limit, self._count = folder, patience, limit, 0
        self._lock = threading.Lock()
        self._ports: dict[str, threading.Lock] = {}
        self._series: dict[str, Path] = {}
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
        self._full = folder / "furnished"
        furnish(self._full)

    def run(self, command: Command) -> str:
        """Run a command and return a report; it begins with WRONG if the command failed."""
        if not f"{command.line} ".startswith(PROGRAMS):
            return "WRONG: no command; a block of something else names its language, as in ```text"
        for beginning, why in NOT_RUN.items():
            if command.line.startswith(beginning):
                return f"not run: {why}"
        if missing := [word for word in command.line.split() if word == "jq" and not shutil.which(word)]:
            return f"not run: {missing[0]} is not installed"
        with self._lock:
            folder = self._folder_for(command)
            ports = [
                self._ports.setdefault(port, threading.Lock()) for port in ports_of(command.line, folder)
            ]
        for port in ports:
            port.acquire()
        try:
            # Programs beside this one take any free port for a moment, also one that a command names.
            for _ in range(TRIES - 1):
                report = self._judged(command, folder)
                if "is in use" not in report:
                    return report
                time.sleep(self._patience)
            return self._judged(command, folder)
        finally:
            for port in ports:
                port.release()

    def _folder_for(self, command: Command) -> Path:
        """Return a folder with the files that the command names, or that of the series that it belongs to.

        A tutorial begins as its reader does: with the examples, and a labelled folder.
        """
        if command.series in self._series:
            return self._series[command.series]
        self._count += 1
        folder = self._folder / str(self._count)
        if command.series:
            self._series[command.series] = folder
            shutil.copytree(self._full / "DIR", folder / "DIR")
            shutil.copytree(ROOT / "examples", folder / "examples")
            return folder
        shutil.copytree(self._full, folder)
        # Outputs of a command are not there before.
        for made in re.findall(r"(?:\brecord \S+|--save) (\S+)", command.line):
            (folder / made).unlink(missing_ok=True)
        return folder

    def _judged(self, command: Command, folder: Path) -> str:
        endless = GOES_ON.search(command.line) is not None
        with subprocess.Popen(  # noqa: S603
            # That is the point: as a reader would type it.
            [
                "/bin/bash",
                "-o",
                "pipefail",
                "-c",
                command.line,
            ],
            cwd=folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        ) as running:
            try:
                out, err = running.communicate(timeout=self._patience if endless else self._limit)
            except subprocess.TimeoutExpired:
                os.killpg(running.pid, signal.SIGINT)
                try:
                    _, err = running.communicate(timeout=GOODBYE)
                except subprocess.TimeoutExpired:
                    os.killpg(running.pid, signal.SIGKILL)
                    return "WRONG: Ctrl-C does not end it"
                if not endless:
                    return f"WRONG: it had not ended after {self._limit:g} s"
                return _interrupted(running.returncode, _said(err))
        return _ended(command, running.returncode, out, _said(err))


def ports_of(line: str, folder: Path) -> list[str]:
    """Return the ports that a command names, itself or in a configuration file, in one order for all commands."""
    files = [folder / name for name in re.findall(r"--config (\S+)", line)]
    texts = [line, *(file.read_text() for file in files if file.is_file())]
    return sorted({port for text in texts for port in re.findall(r"(?::|\brun )(\d{4,5})\b", text)})


def _interrupted(status: int, said: Sequence[str]) -> str:
    """Judge a command that Ctrl-C ended."""
    problems = _problems(said)
    if problems or status not in {DONE, INTERRUPTED, -signal.SIGINT, 128 + signal.SIGINT}:
        return f"WRONG: status {status}: {_last(problems or said)}"
    return "goes on until Ctrl-C"


def _ended(command: Command, status: int, out: bytes, said: Sequence[str]) -> str:
    """Judge a command that ended by itself."""
    for beginning, why in FAILS_HERE.items():
        if command.line.startswith(beginning):
            return f"status 1, rightly: {why}" if status == 1 else f"WRONG: status {status}, though {why}"
    problems = _problems(said)
    if status != DONE or problems:
        return f"WRONG: status {status}: {_last(problems or said)}"
    return "WRONG: nothing comes out of the pipe" if "|" in command.line and not out.strip() else ""


def _said(err: bytes) -> list[str]:
    return err.decode(errors="replace").strip().splitlines()


def _problems(said: Sequence[str]) -> list[str]:
    # Messages of Python itself when Ctrl-C meets it, or a program that it starts, before any line of ours.
    told = [line for line in said if not line.startswith("Fatal Python error: init_")]
    return [line for line in told if re.search(r"\berror:", line, re.IGNORECASE)]


def _last(lines: Sequence[str]) -> str:
    return lines[-1] if lines else "nothing was said"
