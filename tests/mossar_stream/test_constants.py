"""A constant of the core has one meaning: the same public name stands for the same value in all modules."""

import ast
import contextlib
import importlib
import math
import re
from pathlib import Path

import numpy as np

import mossar_stream
from checks import pxi

CORE = Path(mossar_stream.__file__).parent


def constants_of(file):
    """Yield the public constants that a module assigns."""
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                for name in ast.walk(target):
                    if isinstance(name, ast.Name) and name.id.isupper() and not name.id.startswith("_"):
                        yield name.id


def meaning(value):
    """Return a value so that equal ones compare equal: numbers by what they are, whatever their type."""
    return float(value) if isinstance(value, int | float | np.number) else repr(value)


def values(root, package):
    """Return the values of each constant by the modules that assign it."""
    found = {}
    for file in sorted(root.rglob("*.py")):
        names = set(constants_of(file))
        if names:
            path = file.relative_to(root).with_suffix("").parts
            module = importlib.import_module(".".join([package, *path]).removesuffix(".__init__"))
            for name in names:
                found.setdefault(name, {})["/".join(path)] = meaning(getattr(module, name))
    return found


def compiled_values(root):
    """Return the values of each constant of the compiled core by the files that declare it."""
    declared = [
        (file.relative_to(root).as_posix(), name, value)
        for file in sorted(root.rglob("*.pxi"))
        for name, value in pxi.constants(file.read_text(encoding="utf-8"))
    ]
    known, found, waiting = {"__builtins__": {}, "INFINITY": math.inf, "NAN": math.nan}, {}, -1
    while waiting != len(declared):  # some follow from others
        waiting = len(declared)
        for one in list(declared):
            file, name, value = one
            with contextlib.suppress(NameError, SyntaxError):
                known[name] = eval(re.sub(r"<u?int64_t>", "", value), known)
                found.setdefault(name, {})[file] = meaning(known[name])
                declared.remove(one)
    for file, name, value in declared:  # sizes of records
        found.setdefault(name, {})[file] = value
    return found


def test_a_name_has_one_value_in_the_whole_core():
    found = values(CORE, "mossar_stream")
    compiled = compiled_values(CORE)
    assert len(compiled) > 200
    for name, own in compiled.items():
        if not name.startswith("_"):
            found.setdefault(name, {}).update(own)
    several = {name: own for name, own in found.items() if len(set(own.values())) > 1}
    assert several == {}


def test_names_with_two_values_are_found(tmp_path, monkeypatch):
    folder = tmp_path / "package_of_constants"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "one.py").write_text("NEAR, FAR = 1, 2\nSAME: float = 3.0\n")
    (folder / "other.py").write_text("FAR = 2.5\nSAME = 3\n_OWN = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    found = values(folder, "package_of_constants")
    (folder / "two.pxi").write_text(
        "cdef enum:  # some\n    NEAR = 1  # m\n    LAST = MANY - 1\ncdef double WIDE = 2.0 / 4.0  # m\ncdef enum:\n    MANY = 8\n"
    )
    assert compiled_values(folder) == {
        name: {"two.pxi": value}
        for name, value in (("NEAR", 1.0), ("MANY", 8.0), ("WIDE", 0.5), ("LAST", 7.0))
    }
    assert found == {
        "NEAR": {"one": 1.0},
        "FAR": {"one": 2.0, "other": 2.5},
        "SAME": {"one": 3.0, "other": 3.0},
    }
