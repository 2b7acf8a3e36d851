"""One extension, from Cython to the finished file: a process, so that two are made at the same time.

python -m build_core.extension VARIANT -- -O3 ...     # the C compiler's options
python -m build_core.extension --only-c VARIANT       # the C alone: checks.record_copies reads it
"""

import argparse
import gc
from pathlib import Path

import numpy as np
from Cython.Compiler import Main, Options
from setuptools import Distribution, Extension
from setuptools.command.build_ext import build_ext
from setuptools.errors import BaseError, CCompilerError

from build_core.extensions import work_folder
from build_core.sources import PACKAGE, ROOT

DIRECTIVES = {
    "language_level": 3,
    "boundscheck": False,
    "wraparound": False,
    "cdivision": True,
    "initializedcheck": False,
    "nonecheck": False,
    "binding": False,  # functions as C has them: less to compile, quicker to call
}


def write_c(variant: str, *, is_strict: bool) -> Path:
    """Let Cython write the C of an extension, and return its path.

    `cythonize` is not used: it copies headers, and takes an old copy for the header.

    Raises:
        SystemExit: Cython found errors, and has printed them.
    """
    Options.warning_errors = is_strict
    gc.disable()  # the tree is kept to the end: looking for garbage takes a quarter of the time
    path = work_folder(variant) / f"{variant}.c"
    path.parent.mkdir(parents=True, exist_ok=True)
    source = f"mossar_stream/core/{variant}.pyx"
    result = Main.compile(  # type: ignore[no-untyped-call]
        source,
        full_module_name=f"mossar_stream.core.{variant}",
        output_file=str(path),
        compiler_directives=DIRECTIVES,
        include_path=["."],
        emit_linenums=True,  # compilers, sanitizers and perf name the .pxi
    )
    if result.num_errors:
        raise SystemExit(f"Cython does not compile {source}: see above.")
    return path


def compile_and_link(variant: str, flags: list[str]) -> None:
    """Compile the C, and put the extension beside its sources; a process that uses the old one keeps it.

    Raises:
        SystemExit: The compiler found errors, and has printed them.
    """
    folder = work_folder(variant)
    extension = Extension(
        f"mossar_stream.core.{variant}",
        [(folder / f"{variant}.c").relative_to(ROOT).as_posix()],
        extra_compile_args=flags,
        extra_link_args=[flag for flag in flags if flag.startswith("-fsanitize")],
        include_dirs=[str(folder), str(PACKAGE / "core"), str(ROOT), np.get_include()],
        define_macros=[("NPY_NO_DEPRECATED_API", "NPY_1_7_API_VERSION")],
    )
    command = build_ext(Distribution({"ext_modules": [extension]}))
    command.build_temp, command.build_lib, command.force = str(folder / "objects"), str(folder), True
    command.ensure_finalized()
    try:
        command.run()
    except (BaseError, CCompilerError) as error:
        reason = "" if "exit status" in str(error) else f" ({error})"
        raise SystemExit(f"The C compiler does not compile {extension.name}{reason}: see above.") from None
    made = Path(command.get_ext_fullpath(extension.name))
    made.replace(PACKAGE / "core" / made.name)


def main() -> None:
    """Make one."""
    parser = argparse.ArgumentParser(prog="python -m build_core.extension", description=__doc__)
    parser.add_argument("--only-c", action="store_true")
    parser.add_argument("--strict", action="store_true")
    parser.add_argument("variant")
    parser.add_argument("flags", nargs="*")
    options = parser.parse_args()
    write_c(options.variant, is_strict=options.strict)
    if not options.only_c:
        compile_and_link(options.variant, options.flags)


if __name__ == "__main__":
    main()
