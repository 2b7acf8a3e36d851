"""Both extensions, made at the same time, where they are out of date."""

import os
import shlex
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from build_core.compiler import WIDER, commands, flags_for, is_x86_64, warnings
from build_core.sources import PACKAGE, ROOT, as_header, built_from, is_built_from, records

REQUIRED = ("setuptools>=77", "cython>=3.3,<3.4", "numpy>=2")
STRICT = "MOSSAR_STRICT"
SANITIZE = "MOSSAR_SANITIZE"
QUICK = "MOSSAR_QUICK"


def variants() -> list[str]:
    """Return the names of the extensions for this machine."""
    return ["baseline", *([WIDER] if is_x86_64() else [])]


def work_folder(variant: str) -> Path:
    """Return the folder of the C and the objects of an extension."""
    return ROOT / "build" / "core" / (sysconfig.get_config_var("SOABI") or sysconfig.get_platform()) / variant


def build(
    *,
    is_strict: bool = False,
    is_sanitized: bool = False,
    is_forced: bool = False,
    is_quick: bool = False,
    only: str | None = None,
) -> dict[Path, bool]:
    """Compile the core in place; return the extensions, and whether each was compiled.

    Args:
        is_strict: Warnings are errors; unchanged extensions are compiled, too. MOSSAR_STRICT=1 sets it, too.
        is_sanitized: Addresses and undefined behaviour are checked at run time. MOSSAR_SANITIZE=1 sets it, too.
        is_forced: Compile unchanged extensions, too.
        is_quick: Compiling is to be quick, not the extension. MOSSAR_QUICK=1 sets it, too.
        only: One of the two.

    Raises:
        SystemExit: With the compiler's output, or a line about a missing program.
    """
    is_strict |= bool(os.environ.get(STRICT))
    is_sanitized |= bool(os.environ.get(SANITIZE))
    is_quick |= bool(os.environ.get(QUICK))
    header = Path(sysconfig.get_paths()["include"], "Python.h")
    if not header.exists():
        raise SystemExit(f"There is no {header}: install Python's headers (python3-dev), or a wheel.")
    environment = commands()
    finished: dict[Path, bool] = {}
    wanted: dict[str, list[str]] = {}
    for name in variants() if only is None else [only]:
        flags = flags_for(name, environment.get("CC", ""), is_sanitized=is_sanitized, is_quick=is_quick)
        compiler = Path(shlex.split(environment.get("CC", "cl"))[0]).name
        text = built_from(compiler, _recipe(flags))
        path = PACKAGE / "core" / f"{name}{sysconfig.get_config_var('EXT_SUFFIX')}"
        finished[path] = is_forced or is_strict or not is_built_from(path, text)
        if finished[path]:
            strict = ["--strict"] if is_strict else []
            wanted[name] = [
                *strict,
                name,
                "--",
                *flags,
                *warnings(environment.get("CC", ""), is_strict=is_strict),
            ]
            work_folder(name).mkdir(parents=True, exist_ok=True)
            (work_folder(name) / "built_from.h").write_text(
                as_header({"MOSSAR_BUILT_FROM": text, "MOSSAR_RECORDS": records()}), encoding="utf-8"
            )
    run_each(list(wanted.values()), environment)
    return finished


def run_each(arguments: list[list[str]], environment: dict[str, str] | None = None) -> None:
    """Run `build_core.extension` once for each list of arguments, at the same time.

    The first failure is shown alone: errors in shared sources would appear twice.
    """
    path = os.pathsep.join(filter(None, [str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH")]))
    variables = {**os.environ, **(environment or {}), "PYTHONPATH": path}

    def run(words: list[str]) -> subprocess.CompletedProcess[str]:
        program = [sys.executable, "-m", "build_core.extension", *words]
        return subprocess.run(  # noqa: S603
            program, env=variables, cwd=ROOT, capture_output=True, text=True, check=False
        )

    with ThreadPoolExecutor() as pool:
        runs = list(pool.map(run, arguments))
    for done in runs:
        if done.returncode:
            raise SystemExit(f"{done.stdout}{done.stderr}".strip())
    for said in dict.fromkeys(done.stderr for done in runs):
        sys.stderr.write(said)


def _recipe(flags: list[str]) -> str:
    """Return the options that distinguish extensions of the same sources and compiler."""
    import Cython

    ours = "".join(path.read_text(encoding="utf-8") for path in sorted(Path(__file__).parent.glob("*.py")))
    users = [os.environ.get(name) for name in ("CFLAGS", "CPPFLAGS", "LDFLAGS", "ARCHFLAGS")]
    return f"{ours} {flags} {users} {vars(Cython)['__version__']}"
