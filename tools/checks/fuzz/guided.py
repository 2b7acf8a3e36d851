"""Fuzzing that looks where inputs lead: `python -m checks.fuzz.guided TARGET --seconds 60`.

Atheris keeps inputs that reach code no other input has reached, and damages those. It runs on Linux and macOS
(`pip install atheris`). It ends at the first failure and writes the input to a file.
"""

import argparse
import contextlib
import importlib
import sys
import tempfile
from pathlib import Path
from typing import Any

from mossar_stream import MossarError


def main() -> int:
    """Feed one target until the time is over or it fails."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.fuzz.guided", description="Feed a target inputs that reach new code."
    )
    parser.add_argument("target", metavar="TARGET", help="as python -m checks.fuzz names it")
    parser.add_argument("--seconds", metavar="S", type=int, default=60)
    parser.add_argument("--seed", metavar="S", type=int, default=1)
    given = parser.parse_args()
    try:
        atheris: Any = importlib.import_module("atheris")
    except ImportError:
        sys.exit("this needs atheris: pip install atheris")
    with atheris.instrument_imports(include=["mossar_adapters"]):  # the core's loops are compiled
        found = importlib.import_module("checks.fuzz.targets").all_targets()
    targets = {target.name: target for target in found if target.draw is None}
    if given.target not in targets:
        sys.exit(f"no such target; there are {', '.join(targets)}")
    target = targets[given.target]
    with target.open() as feed, tempfile.TemporaryDirectory() as folder:
        for i, sample in enumerate(target.samples):
            (Path(folder) / str(i)).write_bytes(sample)

        def once(data: bytes) -> None:
            with contextlib.suppress(MossarError):
                feed(data)

        limits = [
            f"-max_total_time={given.seconds}",
            f"-seed={given.seed}",
            "-timeout=10",
            "-rss_limit_mb=1024",
        ]
        atheris.Setup([sys.argv[0], *limits, "-print_final_stats=1", folder], once)
        atheris.Fuzz()
    return 0


if __name__ == "__main__":
    sys.exit(main())
