"""Sizes: `python -m checks.sizes` lists packages of many modules, and long files and functions.

A row is a place to look, not a defect: a file of 500 lines that tells one story beats two of 250 that need each other.
"""

import argparse
import ast
import sys
from collections.abc import Iterator
from pathlib import Path

from checks import pxi

ROOT = Path(__file__).parents[2]
FOLDERS = ("mossar_stream", "adapters/mossar_adapters", "tools/mossar_tools", "tools/checks")
MOST_MODULES = 16  # of a package, subpackages included
LONGEST_FILE, LONGEST_FUNCTION = 400, 60  # lines
SOURCES = (".py", ".pxi", ".h")


def main() -> int:
    """Print the largest packages, files and functions, and return 0."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.sizes", description="List large packages, files and functions."
    )
    parser.add_argument("folders", metavar="DIR", nargs="*", help=f"default: {', '.join(FOLDERS)}")
    given = parser.parse_args()
    folders = [Path(folder) for folder in given.folders] or [ROOT / folder for folder in FOLDERS]
    missing = [folder for folder in folders if not folder.is_dir()]
    if missing:
        parser.error(f"there is no folder {missing[0]}")
    for kind, find in (("modules", large_packages), ("lines", long_files), ("lines", long_functions)):
        for size, place in sorted((row for folder in folders for row in find(folder)), reverse=True):
            print(f"{size:>6} {kind}  {place}")
    return 0


def large_packages(folder: Path) -> Iterator[tuple[int, str]]:
    """Yield packages with more modules than usual: their number, and the package."""
    for package in sorted({file.parent for file in _files(folder)}):
        inside = [p for p in package.iterdir() if p.suffix in SOURCES or (p / "__init__.py").exists()]
        if len(inside) > MOST_MODULES:
            yield len(inside), _place(package)


def long_files(folder: Path) -> Iterator[tuple[int, str]]:
    """Yield files that are longer than usual: their lines, and the file."""
    for file in _files(folder):
        lines = len(file.read_text(encoding="utf-8").splitlines())
        if lines > LONGEST_FILE:
            yield lines, _place(file)


def long_functions(folder: Path) -> Iterator[tuple[int, str]]:
    """Yield functions that are longer than usual: their lines, and where they begin."""
    for file in _files(folder):
        for line, name, lines in _functions(file):
            if lines > LONGEST_FUNCTION:
                yield lines, f"{_place(file)}:{line} {name}"


def _functions(file: Path) -> Iterator[tuple[int, str, int]]:
    """Yield the first lines of the functions of a file, their names, and their numbers of lines."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".pxi":
        yield from (own[:3] for own in pxi.functions(text))
    elif file.suffix == ".py":
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield node.lineno, node.name, (node.end_lineno or node.lineno) - node.lineno + 1


def _files(folder: Path) -> list[Path]:
    return sorted(file for file in folder.rglob("*") if file.suffix in SOURCES)


def _place(path: Path) -> str:
    return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.as_posix()


if __name__ == "__main__":
    sys.exit(main())
