"""What docstrings and comments of the core name is there: files, names of modules, private names."""

import ast
import builtins
import io
import re
import tokenize
from pathlib import Path

import pytest

import mossar_stream
from checks import pxi

CORE = Path(mossar_stream.__file__).parent
ROOT = CORE.parent
FILES = sorted(file for file in CORE.rglob("*") if file.suffix in {".py", ".pxi"})
IN_REPOSITORY = {
    path.name
    for folder in ("mossar_stream", "adapters", "tools", "tests", "docs", "examples")
    for path in (ROOT / folder).rglob("*")
    if path.suffix in {".py", ".pyi", ".md", ".pxi", ".h"}
} | {path.name for path in ROOT.glob("*.md")}
NAMED_FILE = re.compile(r"\b(?:[\w-]+/)*([\w-]+\.(?:pyi?|md|pxi|h))\b")
IN_BACKTICKS = re.compile(r"`([A-Za-z_][\w.]*)`")


def words_of(file):
    """Return the comments and docstrings of a module, or of a file of Cython."""
    source = file.read_text(encoding="utf-8")
    if file.suffix == ".pxi":
        return pxi.words(source)
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    comments = [token.string for token in tokens if token.type == tokenize.COMMENT]
    kinds = ast.Module | ast.ClassDef | ast.FunctionDef
    docstrings = [ast.get_docstring(node) for node in ast.walk(ast.parse(source)) if isinstance(node, kinds)]
    return [*comments, *filter(None, docstrings)]


def defined_in(file):
    """Return all names that a module binds: functions, classes, attributes, arguments, variables, imports, fields."""
    if file.suffix == ".pxi":
        return pxi.names(file.read_text(encoding="utf-8"))
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        found |= {
            getattr(node, name)
            for name in ("name", "attr", "arg", "id", "asname")
            if isinstance(getattr(node, name, None), str)
        }
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier():
            found.add(node.value)  # fields of records, values of settings
    return found


DEFINED = {file: defined_in(file) for file in FILES}
MODULES = {}
for file in FILES:
    MODULES.setdefault(file.parent.name if file.name == "__init__.py" else file.stem, []).append(file)
EVERYWHERE = set().union(*DEFINED.values(), dir(builtins))


def dangling(file):
    """Yield what the words of a module name, and is not there."""
    for text in words_of(file):
        yield from (name for name in NAMED_FILE.findall(text) if name not in IN_REPOSITORY)
        for name in IN_BACKTICKS.findall(text):
            first, _, last = name.rpartition(".")
            module = first.rpartition(".")[2]
            if module in MODULES and last not in {"py", "pyi", "md", "pxi", "h"}:
                homes = [DEFINED[home] for home in MODULES[module]]
                if not any(last in own for own in homes) and last not in MODULES:
                    yield name
            elif not first and "_" in name and name not in {*EVERYWHERE, *MODULES}:
                yield name


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.relative_to(CORE).as_posix())
def test_what_is_named_is_there(file):
    assert not list(dangling(file))


def test_a_dangling_reference_is_found(tmp_path):
    file = tmp_path / "made.py"
    file.write_text(
        '"""See no_such_page.md, `splitter.no_such_name`, `_no_such_private`, and `splitter.Curve`."""\nx = 1  # gone.py\n'
    )
    assert sorted(dangling(file)) == [
        "_no_such_private",
        "gone.py",
        "no_such_page.md",
        "splitter.no_such_name",
    ]
