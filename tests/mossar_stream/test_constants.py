"""A constant of the core has one meaning: the same public name stands for the same value in all modules."""

import ast
import importlib
from pathlib import Path

import numpy as np

import mossar_stream

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


def test_a_name_has_one_value_in_the_whole_core():
    several = {name: own for name, own in values(CORE, "mossar_stream").items() if len(set(own.values())) > 1}
    assert several == {}


def test_names_with_two_values_are_found(tmp_path, monkeypatch):
    folder = tmp_path / "package_of_constants"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "one.py").write_text("NEAR, FAR = 1, 2\nSAME: float = 3.0\n")
    (folder / "other.py").write_text("FAR = 2.5\nSAME = 3\n_OWN = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    found = values(folder, "package_of_constants")
    assert found == {
        "NEAR": {"one": 1.0},
        "FAR": {"one": 2.0, "other": 2.5},
        "SAME": {"one": 3.0, "other": 3.0},
    }
