"""The core's tests with a core that checks addresses and undefined behaviour (gcc's or clang's sanitizers).

    python -m checks.sanitized                          # tests/mossar_stream
    python -m checks.sanitized tests/mossar_stream/core -x
    python -m checks.sanitized --program -m checks.fuzz --inputs 20000 --seconds 60
    python -m checks.sanitized tests/mossar_stream/core --program -m checks.fuzz      # the tests, then the program

The project is copied into a temporary folder and compiled there, so that the core in use does not change. Two defects are
planted in the copy: unless both are found, the sanitizers do not work, and nothing else is run.

Not found: a write into another array of the same block, and use of memory that was never set.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from build_core.compiler import configured

ROOT = Path(__file__).parents[2]
COPIED = (
    "README.md",
    "CHANGELOG.md",
    "LICENSE",
    "pyproject.toml",
    "adapters",
    "docs",
    "examples",
    "mossar_stream",
    "tests",
    "tools",
)
LEFT = shutil.ignore_patterns("__pycache__", "*.so", "*.c", "node_modules", "site", ".*_cache")
PLANTED = """

from libc.stdlib cimport free, malloc


def _planted_address(Py_ssize_t index):
    cdef double* room = <double*> malloc(8 * sizeof(double))
    room[index] = 1.0
    value = room[index]
    free(room)
    return value


def _planted_overflow(int64_t value, int64_t more):
    return value + more
"""
PLANTS = {
    "_planted_address(8)": "heap-buffer-overflow",
    "_planted_overflow(2**62, 2**62)": "signed integer overflow",
}
CORE = {"MOSSAR_CORE": "baseline"}


def main() -> int:
    """Compile, find the planted errors, run the tests, the program or both, and return the first status that is not 0."""
    words = sys.argv[1:]
    if {"-h", "--help"} & set(words):
        print(__doc__)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in COPIED:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, copy / name, ignore=LEFT)
            elif source.exists():
                shutil.copy(source, copy)
        with (copy / "mossar_stream" / "core" / "core.pxi").open("a", encoding="utf-8") as file:
            file.write(PLANTED)
        paths = os.pathsep.join(str(path) for path in (copy, copy / "adapters", copy / "tools"))
        variables = {**os.environ, **CORE, "PYTHONPATH": paths}
        program = [sys.executable, "-m", "build_core", "--sanitize", "--only", "baseline"]
        subprocess.run(program, cwd=copy, env=variables, check=True)  # noqa: S603
        variables |= sanitizer_variables()
        for call, message in PLANTS.items():
            if not is_found(call, message, copy, variables):
                print(f"{call} was planted, and the sanitizers did not find it")
                return 1
        print("The planted errors were found.", flush=True)
        for program in programs(words):
            done = subprocess.run([sys.executable, *program], cwd=copy, env=variables, check=False)  # noqa: S603
            if done.returncode:
                return done.returncode
        return 0


def programs(words: list[str]) -> list[list[str]]:
    """Return the commands for Python, by the words of the command line."""
    split = words.index("--program") if "--program" in words else len(words)
    tests, program = words[:split], words[split + 1 :]
    pytest = ["-m", "pytest", "-p", "no:cacheprovider", *(tests or ["tests/mossar_stream"])]
    return [*([pytest] if tests or not program else []), *([program] if program else [])]


def sanitizer_variables() -> dict[str, str]:
    """Return the variables with which a Python without the sanitizers loads a core with them."""
    libraries = []
    # C++ must be there before the first exception of a library.
    for name in (
        "libasan.so",
        "libubsan.so",
        "libstdc++.so",
    ):
        program = [*(configured() or "cc").split(), f"-print-file-name={name}"]
        libraries.append(subprocess.run(program, capture_output=True, text=True, check=True).stdout.strip())  # noqa: S603
    return {
        "LD_PRELOAD": ":".join(libraries),
        # Python and its libraries keep their memory until the end; each object has memory of its own.
        "ASAN_OPTIONS": "detect_leaks=0:abort_on_error=0",
        "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
        "PYTHONMALLOC": "malloc",
    }


def is_found(call: str, message: str, copy: Path, variables: dict[str, str]) -> bool:
    """Run a call of a planted error, and return whether it ended with the message."""
    program = [sys.executable, "-c", f"from mossar_stream.core import baseline; baseline.{call}"]
    done = subprocess.run(program, cwd=copy, env=variables, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode == 0 or message not in done.stderr:
        print(done.stdout + done.stderr)
        return False
    return True


if __name__ == "__main__":
    sys.exit(main())
