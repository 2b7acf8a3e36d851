"""The C compiler of this machine, and its options."""

import os
import platform
import shlex
import shutil
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path

ZIG = "ziglang>=0.13"
GLIBC = "2.17"  # the oldest that manylinux2014 wheels run with; zig would take its newest otherwise
OPTIMISED = ["-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
QUICK = ["-O1", *OPTIMISED[1:]]  # the same results, later
SANITIZED = [
    "-O1",
    "-g",
    "-ffp-contract=off",
    "-fno-wrapv",  # Python's own flags let integers wrap: an overflow would not be found
    "-fsanitize=address,undefined,float-cast-overflow",
    "-fno-sanitize=object-size",  # finds and reports less than the check of addresses
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
]
# Warnings that Cython's C causes by design: parameters of slots, initialisers that end early, casts of functions.
STRICT = [
    "-Wall",
    "-Wextra",
    "-Werror",
    "-Wno-unused-parameter",
    "-Wno-missing-field-initializers",
    "-Wno-cast-function-type",
]
# MSVC: no contraction of a * b + c either, and errno is its own affair.
MICROSOFT = ["/O2", "/fp:precise"]
WIDER = "x86_64_v3"


def is_x86_64() -> bool:
    """Return whether the extension is for x86-64, also where it is made on another machine (macOS)."""
    flags = os.environ.get("ARCHFLAGS", "")
    machine = flags if "-arch" in flags else platform.machine()
    return sys.maxsize > 2**32 and any(name in machine.lower() for name in ("x86_64", "amd64"))


def configured(which: Callable[[str], str | None] = shutil.which) -> str | None:
    """Return the command of the C compiler of this system, or None if there is none.

    Windows has Microsoft's, which setuptools finds.

    Raises:
        SystemExit: CC names a program that is not there.
    """
    wish = os.environ.get("CC")
    if wish:
        if which(shlex.split(wish)[0]) is None:
            raise SystemExit(f"CC={wish}: there is no such program")
        return wish
    if sys.platform == "win32":
        return "cl"
    candidates = (sysconfig.get_config_var("CC"), "cc", "gcc", "clang")
    return next((command for command in candidates if command and which(shlex.split(command)[0])), None)


def zig_command() -> str:
    """Return the command of the compiler that the distribution `ziglang` brings, for any machine of this kind.

    Raises:
        SystemExit: The distribution is not installed.
    """
    try:
        import ziglang
    except ImportError:
        raise SystemExit(f"There is no C compiler: install gcc or clang, or `pip install '{ZIG}'`.") from None

    zig = Path(ziglang.__file__).with_name("zig")
    machine = "aarch64" if platform.machine().lower() in {"arm64", "aarch64"} else platform.machine().lower()
    if sys.platform == "darwin":
        target = f"{machine}-macos"
    elif "musl" in (sysconfig.get_config_var("SOABI") or ""):
        target = f"{machine}-linux-musl"
    else:
        target = f"{machine}-linux-gnu.{GLIBC}"
    return shlex.join([str(zig), "cc", "-target", target, *_multiarch_headers()])


def _multiarch_headers() -> list[str]:
    """Return the option by which zig finds the header that Debian's pyconfig.h includes from outside Python's folder."""
    headers, multiarch = Path(sysconfig.get_paths()["include"]), sysconfig.get_config_var("MULTIARCH") or ""
    if not (headers.parent / multiarch / headers.name / "pyconfig.h").is_file():
        return []
    return ["-idirafter", str(headers.parent)]  # after the headers of zig's own C library


def commands() -> dict[str, str]:
    """Return the commands that setuptools reads from the environment, to compile and to link.

    Python's own command for linking has options that a system may need; its first word is the compiler, which is replaced.
    Zig's linker refuses some of those that a distribution adds on Linux, and needs none of them.
    """
    if sys.platform == "win32" and not os.environ.get("CC"):
        return {}
    compiler = configured()
    _, *options = shlex.split(sysconfig.get_config_var("LDSHARED") or "cc -shared")
    if compiler is None:
        compiler = zig_command()
        if sys.platform != "darwin":
            options = ["-shared"]
    return {"CC": compiler, "LDSHARED": f"{compiler} {shlex.join(options)}"}


def flags_for(variant: str, command: str, *, is_sanitized: bool, is_quick: bool = False) -> list[str]:
    """Return the options of one of the two extensions.

    Args:
        variant: `baseline` or `x86_64_v3`.
        command: The compiler's, as `commands` has it; empty for Microsoft's.
        is_sanitized: Addresses and undefined behaviour are checked at run time.
        is_quick: Compiling is to be quick, not the extension.
    """
    if not command:
        return [
            *MICROSOFT,
            *(["/arch:AVX2"] if variant == WIDER else []),
        ]
    flags = list(SANITIZED if is_sanitized else QUICK if is_quick else OPTIMISED)
    if not is_sanitized and "CFLAGS" not in os.environ:
        # Python's own flags have -g: ten times the size. CFLAGS=-g keeps lines for a profiler.
        flags.append("-g0")
    return flags + _level(variant, command)


def warnings(command: str, *, is_strict: bool) -> list[str]:
    """Return the options that decide which warnings there are, and that they are errors where `is_strict`."""
    if not command:
        return ["/W3", "/WX"] if is_strict else []
    return STRICT if is_strict else ["-Wno-unused-function"]


def _level(variant: str, command: str) -> list[str]:
    """Return the options that name the processor: never the one of this machine."""
    if "zig" in Path(shlex.split(command)[0]).name:
        return [f"-mcpu={WIDER if variant == WIDER else 'baseline'}"]
    if sys.platform == "darwin":  # -Xarch: an extension may hold code for arm64, too
        return ["-Xarch_x86_64", "-march=x86-64-v3"] if variant == WIDER else []
    if not is_x86_64():
        return []
    return ["-march=x86-64-v3" if variant == WIDER else "-march=x86-64"]
