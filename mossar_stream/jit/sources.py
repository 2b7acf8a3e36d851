"""The state of the sources that kernels are compiled from, as a name.

Only modules that hold kernels count, and what those import: constants and record types are compiled into kernels. Of
each module counts what Python compiles it to without docstrings, comments and line numbers. So an edit of a docstring,
or of a module without kernels, leaves compiled kernels valid. A checkout of an older commit finds its kernels again.
"""

import hashlib
from pathlib import Path
from types import CodeType
from typing import Any

import numba

PACKAGE = Path(__file__).parents[1]
DECLARATIONS = {"kernel", "inline_kernel", "entry_point", "linked"}  # a module that uses one holds kernels
WITHOUT_DOCSTRINGS = 2  # level of optimisation of Python's compiler


def digest(package: Path = PACKAGE) -> str:
    """Return the name of the state of a package's kernels with this version of numba.

    Args:
        package: Folder of the package, subfolders included.
    """
    modules = {_module_name(file, package): _compiled(file) for file in package.rglob("*.py")}
    found: set[str] = set()
    open_names = [name for name, code in modules.items() if not DECLARATIONS.isdisjoint(code.co_names)]
    while open_names:
        name = open_names.pop()
        if name not in found:
            found.add(name)
            open_names += _imported(modules[name]) & modules.keys()
    contents = [f"{name}: {_contents(modules[name])!r}" for name in sorted(found)]
    return hashlib.sha256("\n".join([numba.__version__, *contents]).encode()).hexdigest()[:16]


def _module_name(file: Path, package: Path) -> str:
    parts = file.relative_to(package).with_suffix("").parts
    return ".".join([PACKAGE.name, *(part for part in parts if part != "__init__")])


def _compiled(file: Path) -> CodeType:
    return compile(file.read_bytes(), file.name, "exec", dont_inherit=True, optimize=WITHOUT_DOCSTRINGS)


def _imported(code: CodeType) -> set[str]:
    """Return the names of modules that may be what a module imports: `a.b` and `a.b.c` for `from a.b import c`."""
    packages = [name for name in code.co_names if name.startswith(PACKAGE.name)]
    return {*packages, *(f"{package}.{name}" for package in packages for name in code.co_names)}


def _contents(value: Any) -> object:
    """Return what a constant of compiled Python says, without the places in the file that it came from."""
    if isinstance(value, CodeType):
        names = value.co_names, value.co_varnames, value.co_freevars, value.co_cellvars
        counts = value.co_argcount, value.co_posonlyargcount, value.co_kwonlyargcount, value.co_flags
        return value.co_name, value.co_code, names, counts, _contents(value.co_consts)
    if isinstance(value, frozenset):  # the order of its members differs from process to process
        return "set", sorted(map(repr, value))
    if isinstance(value, tuple):
        return tuple(map(_contents, value))
    return value
