"""The two extensions, each from Cython to the finished file, at the same time."""

import os
import shlex
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from build_core.compiler import WIDER, commands, flags_for, is_x86_64
from build_core.sources import PACKAGE, ROOT, as_header, built_from, is_built_from

REQUIRED = ("setuptools>=77", "cython>=3.3,<3.4", "numpy>=2")
DIRECTIVES = {
    "language_level": "3",
    "boundscheck": "False",
    "wraparound": "False",
    "cdivision": "True",
    "initializedcheck": "False",
    "nonecheck": "False",
}


def build(
    *, is_strict: bool = False, is_sanitized: bool = False, is_forced: bool = False, only: str | None = None
) -> dict[Path, bool]:
    """Compile the core in place, where it is out of date; return the extensions, and whether each was compiled.

    Args:
        is_strict: Warnings are errors.
        is_sanitized: Addresses and undefined behaviour are checked at run time.
        is_forced: Compile what is up to date, too.
        only: One of the two.

    Raises:
        SystemExit: With what the compiler said, or a line that says what to install.
    """
    header = Path(sysconfig.get_paths()["include"], "Python.h")
    if not header.exists():
        raise SystemExit(f"There is no {header}: install Python's headers (python3-dev, python3-devel), or a wheel.")
    import Cython  # noqa: PLC0415 - hook.py is read before it is installed

    environment = commands()
    os.environ.update(environment)
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    variants = [name for name in ("baseline", *([WIDER] if is_x86_64() else [])) if only in {None, name}]
    flags = {
        name: flags_for(name, environment.get("CC", ""), is_strict=is_strict, is_sanitized=is_sanitized) for name in variants
    }
    ours = "".join(path.read_text(encoding="utf-8") for path in sorted(Path(__file__).parent.glob("*.py")))
    compiler = Path(shlex.split(environment.get("CC", "cl"))[0]).name
    said = f"{ours} {compiler} {os.environ.get('CFLAGS')} {Cython.__version__}"
    recipes = {name: built_from(f"{said} {flags[name]}") for name in variants}
    finished = {name: PACKAGE / "core" / f"{name}{suffix}" for name in variants}
    wanted = [name for name in variants if is_forced or not is_built_from(finished[name], recipes[name])]
    if wanted:
        _compile({name: recipes[name] for name in wanted}, flags, finished, is_strict=is_strict)
    return {finished[name]: name in wanted for name in variants}


def work_folder() -> Path:
    """Return where C and objects of this Python's extensions are kept."""
    return ROOT / "build" / "core" / (sysconfig.get_config_var("SOABI") or sysconfig.get_platform())


def _compile(recipes: dict[str, str], flags: dict[str, list[str]], finished: dict[str, Path], *, is_strict: bool) -> None:
    import numpy as np  # noqa: PLC0415
    from setuptools import Distribution, Extension  # noqa: PLC0415
    from setuptools.command.build_ext import build_ext  # noqa: PLC0415

    class Both(build_ext):  # type: ignore[misc,unused-ignore] # setuptools may have no types
        """Cython and the C compiler for one extension in one thread, so that both extensions are made at once."""

        def build_extensions(self) -> None:
            if self.compiler.compiler_type == "unix":
                self.compiler.spawn = _run
            super().build_extensions()

        def build_extension(self, ext: Any) -> None:
            name = ext.name.rpartition(".")[2]
            write_c(name, work_folder() / name, is_strict=is_strict)
            super().build_extension(ext)

    for name, recipe in recipes.items():
        (work_folder() / name).mkdir(parents=True, exist_ok=True)
        (work_folder() / name / "built_from.h").write_text(as_header(recipe), encoding="utf-8")
    extensions = [
        Extension(
            f"mossar_stream.core.{name}",
            [(work_folder() / name / f"{name}.c").relative_to(ROOT).as_posix()],
            extra_compile_args=flags[name],
            extra_link_args=[flag for flag in flags[name] if flag.startswith("-fsanitize")],
            include_dirs=[str(work_folder() / name), str(PACKAGE / "core"), str(ROOT), np.get_include()],
            define_macros=[("NPY_NO_DEPRECATED_API", "NPY_1_7_API_VERSION")],
        )
        for name in recipes
    ]
    before = Path.cwd()
    os.chdir(ROOT)  # paths in messages and tracebacks begin at the root
    try:
        command = Both(Distribution({"ext_modules": extensions}))
        command.build_temp, command.build_lib = "build/core/objects", str(work_folder() / "lib")
        command.parallel, command.force = len(extensions), True
        command.ensure_finalized()
        command.run()
        for extension in extensions:
            name = extension.name.rpartition(".")[2]
            # Replaced as a whole: a process that uses the old one keeps it.
            Path(command.get_ext_fullpath(extension.name)).replace(finished[name])
    except Exception as error:
        raise SystemExit(str(error)) from None
    finally:
        os.chdir(before)


def write_c(name: str, folder: Path, *, is_strict: bool = False) -> Path:
    """Write the C of one of the two extensions into a folder, and return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.c"
    options = [word for item in DIRECTIVES.items() for word in ("-X", "=".join(item))]
    strict = ["-Werror"] if is_strict else []
    program = [sys.executable, "-m", "cython", *options, *strict, "-I", ".", "-o", str(path), f"mossar_stream/core/{name}.pyx"]
    _run(program, cwd=ROOT)
    return path


def _run(command: list[str], **options: Any) -> None:
    """Run a compiler; show its warnings. What it says when it fails is the message, so that two do not mix theirs."""
    options = {key: value for key, value in options.items() if key in {"cwd", "env"}}
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    said = (done.stdout + done.stderr).strip()
    if done.returncode:
        raise RuntimeError(f"{said}\n{shlex.join(map(str, command[:3]))} … ended with status {done.returncode}")
    if said:
        sys.stderr.write(f"{said}\n")
