"""What docs/architecture.md says of the core is there, under that name and in that order."""

import ast
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CORE = ROOT / "mossar_stream"
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
ROOMS = "core|engine|following|moves|poses|readers|repetitions|segmenter|similarity|steps"
NAMES = sorted(set(re.findall(rf"`((?:{ROOMS})\.[a-zA-Z_.]+)`", PAGE[PAGE.index("## One push") :])))
COMPILED = PAGE[PAGE.index("## The compiled core") : PAGE.index("## From datagram")]
IN_CORE = re.findall(r"`(\w+\.pxi)`", "".join(re.findall(r"^\| (`\w+\.pxi`.*?) \|", COMPILED, re.MULTILINE)))
IN_ROOMS = {
    room: re.findall(r"`(\w+\.pxi)`", files)
    for room, files in re.findall(r"^\| `(\w+)/` \| (.*) \|$", COMPILED, re.MULTILINE)
}
FLOORS = {
    room.rstrip("/"): int(floor)
    for floor, rooms in re.findall(r"^(\d)   (\S+(?: {2}\S+)*)", PAGE, re.MULTILINE)
    for room in rooms.split()
}


def cython_file(parts):
    """Return the file of Cython that a name begins with, and what is left of the name."""
    for count in range(len(parts), 0, -1):
        path = CORE.joinpath(*parts[:count]).with_suffix(".pxi")
        if path.exists():
            return path, parts[count:]
    return None, parts


def python_object(parts):
    """Return what a name of Python stands for."""
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(("mossar_stream", *parts[:count])))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            found = getattr(found, part)
        return found
    raise AssertionError(parts)


@pytest.mark.parametrize("name", NAMES)
def test_every_step_of_a_push_is_where_the_page_says(name):
    path, rest = cython_file(name.split("."))
    if path is None:
        python_object(rest)
    for function in rest if path else ():
        assert re.search(
            rf"^(?:cdef |cpdef |def )[^=\n]*\b{function}\(", path.read_text(encoding="utf-8"), re.MULTILINE
        )


def test_steps_are_named():
    assert len(NAMES) > 12


def included(path):
    """Yield the files that a file of Cython includes, and those that these include, in order."""
    for name in re.findall(r"^include \"(.+)\"", path.read_text(encoding="utf-8"), re.MULTILINE):
        homes = path.parent, CORE / "core", ROOT
        found = next(home / name for home in homes if (home / name).exists()).resolve()
        yield found
        yield from included(found)


def test_files_of_the_core_are_listed_in_the_order_of_their_inclusion():
    home = CORE / "core"
    order = [path.name for path in included(home / "core.pxi") if path.parent == home.resolve()]
    assert order == IN_CORE
    assert {path.name for path in home.glob("*.pxi")} == {"core.pxi", *IN_CORE}


def test_files_of_the_other_rooms_are_listed():
    found = {}
    for path in CORE.rglob("*.pxi"):
        found.setdefault(path.relative_to(CORE).parts[0], set()).add(path.name)
    del found["core"]
    assert {room: set(names) for room, names in IN_ROOMS.items()} == found


def rooms_imported_by(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "mossar_stream":
            names = [node.module] if "." in node.module else [f"mossar_stream.{n.name}" for n in node.names]
            yield from (name.split(".")[1] for name in names)


def test_rooms_import_nothing_from_a_floor_above():
    rooms = {path.relative_to(CORE).with_suffix("").parts[0] for path in CORE.rglob("*.py")} - {"__init__"}
    assert rooms == set(FLOORS)
    upward = {
        f"{path.relative_to(CORE)}: {room}"
        for path in CORE.rglob("*.py")
        for room in rooms_imported_by(path)
        if path.parent != CORE or path.stem != "__init__"
        if FLOORS.get(room, 0) > FLOORS[path.relative_to(CORE).with_suffix("").parts[0]]
    }
    assert not upward
