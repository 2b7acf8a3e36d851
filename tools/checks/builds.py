"""Every way in which the project is built and installed, with the system's compiler and with zig alone.

    python -m checks.builds                  # one minute and a half on two cores; needs the package index
    python -m checks.builds --compilers zig

For each compiler, in fresh environments: an sdist, a wheel from the sdist, the wheel installed and used; then an editable
install of the sdist's content, compiled with little optimisation, used, and refused when a source has changed. For zig, PATH has no compiler.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import venv
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[2]
COMPILERS = ("system", "zig")
PATIENCE = 900.0  # s, for one command
# Requirements of the core alone; the others are not built here.
NEEDS = ("numpy", "msgspec")
USE = """
import os, sys
from mossar_stream.core import kernels
core = kernels._core
print(core.__name__.rpartition(".")[2], core.BUILT_FROM.split()[2], os.path.dirname(core.__file__))
"""


class Refused(Exception):  # noqa: N818 - it names the event
    """A step did not end as it should."""


def main() -> int:
    """Build and install in every way; print a line for each, and return whether one failed."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.builds",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--compilers", nargs="+", choices=COMPILERS, default=COMPILERS)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(len(given.compilers)) as pool:
        home = Path(folder)
        run([sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(home)], home, cwd=ROOT)
        [sdist] = home.glob("*.tar.gz")
        failures = list(pool.map(lambda name: try_compiler(name, sdist, home / name), given.compilers))
    return 1 if any(failures) else 0


def try_compiler(compiler: str, sdist: Path, home: Path) -> bool:
    """Try every way with one compiler; print failures, and return whether there were any."""
    try:
        try_wheel(compiler, sdist, home)
        try_editable(compiler, sdist, home)
    except (Refused, subprocess.TimeoutExpired) as error:
        print(f"{compiler}: {error}", flush=True)
        return True
    return False


def try_wheel(compiler: str, sdist: Path, home: Path) -> None:
    """Build a wheel from the sdist, look into it, install and use it."""
    python = environment(home / "wheel")
    began = time.perf_counter()
    pip(python, compiler, "wheel", "--no-deps", "--no-cache-dir", "-w", str(home), str(sdist))
    took = time.perf_counter() - began
    [wheel] = home.glob("*.whl")
    if "-none-any" in wheel.name:
        raise Refused(f"{wheel.name} says that it is for every system")
    pip(python, compiler, "install", "--no-deps", str(wheel))
    used = use(python, home)
    check(used, compiler, home / "wheel")
    print(
        f"{compiler}: wheel from the sdist in {took:.0f} s, {wheel.stat().st_size / 1e6:.1f} MB: {used}",
        flush=True,
    )


def try_editable(compiler: str, sdist: Path, home: Path) -> None:
    """Install the sdist's content as a checkout; change a source, and check that the core is refused."""
    python = environment(home / "editable")
    with tarfile.open(sdist) as archive:
        archive.extractall(home / "checkout", filter="data")
    [checkout] = (home / "checkout").iterdir()
    began = time.perf_counter()
    pip(python, compiler, "install", "--no-deps", "-e", str(checkout), MOSSAR_QUICK="1")
    took = time.perf_counter() - began
    used = use(python, home)
    check(used, compiler, checkout)
    with (checkout / "mossar_stream" / "core" / "core.pxi").open("a", encoding="utf-8") as file:
        file.write("# changed\n")
    try:
        use(python, home)
    except Refused as error:
        last = str(error).strip().splitlines()[-1]
        if "core.pxi: run `python -m build_core` or `pip install -e .`" not in last:
            raise
    else:
        raise Refused("a core that is older than its sources was used")
    print(f"{compiler}: editable install in {took:.0f} s: {used}", flush=True)


def check(used: str, compiler: str, home: Path) -> None:
    """See that the core that was used is this one, from this compiler, and the one for this processor."""
    variant, program, folder = used.split(maxsplit=2)
    if not Path(folder).resolve().is_relative_to(home.resolve()):
        raise Refused(f"the core of {folder} was used")
    if (program == "zig") != (compiler == "zig"):
        raise Refused(f"{program} compiled")
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists() and (" avx2 " in cpuinfo.read_text()) != (variant == "x86_64_v3"):
        raise Refused(f"{variant} was chosen")


def environment(folder: Path) -> Path:
    """Make a fresh environment with the requirements of the core; return its Python."""
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    pip(python, "system", "install", *NEEDS)
    return python


def pip(python: Path, compiler: str, *words: str, **variables: str) -> None:
    """Run pip of an environment, with further variables; with zig, as on a machine without a compiler."""
    command = [str(python), "-m", "pip", "--disable-pip-version-check", "-q", *words]
    run(command, python.parent, compiler=compiler, more=variables)


def use(python: Path, home: Path) -> str:
    """Import the core, and return its own description."""
    return run([str(python), "-c", USE], home).strip()


def run(
    command: list[str],
    home: Path,
    *,
    cwd: Path | None = None,
    compiler: str = "system",
    more: dict[str, str] | None = None,
) -> str:
    """Run a command; return its output.

    Args:
        command: Its words.
        home: Working folder without `cwd`, and with zig the only place of programs.
        cwd: Working folder.
        compiler: `system` or `zig`.
        more: Further variables of the environment.

    Raises:
        Refused: It ended with another status than 0.
    """
    variables = {
        name: value for name, value in os.environ.items() if name not in {"PYTHONPATH", "MOSSAR_CORE", "CC"}
    } | (more or {})
    if compiler == "zig":
        variables["PATH"] = str(home)
        if shutil.which("cc", path=str(home)):
            raise Refused(f"there is a compiler in {home}")
    done = subprocess.run(  # noqa: S603
        command, cwd=cwd or home, env=variables, capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    if done.returncode:
        raise Refused(f"{' '.join(command[:6])} …\n{done.stdout}{done.stderr}")
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
