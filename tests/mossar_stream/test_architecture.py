"""What docs/architecture.md says of the core is there, under that name and in that order."""

import ast
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CORE = ROOT / "mossar_stream"
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
ROOMS = "core|following|moves|poses|repetitions|segmenter|similarity|steps"
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


def is_cython(parts):
    """Tell whether a name is a file of Cython, or a function or record in one."""
    for count in range(len(parts), 0, -1):
        path = CORE.joinpath(*parts[:count]).with_suffix(".pxi")
        if path.exists():
            patterns = (
                rf"^ *(?:cdef |cpdef |def )[^:=]*?\b{name}\(|^cdef struct {name}:" for name in parts[count:]
            )
            text = path.read_text(encoding="utf-8")
            return all(re.search(pattern, text, re.MULTILINE) for pattern in patterns)
    return False


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
    parts = name.split(".")
    assert is_cython(parts) or python_object(parts)


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


def room_of(module):
    """Return the room of a module; the compiled core has a floor of its own."""
    parts = module.split(".")[1:]
    return "core.kernels" if parts in (["core", "kernels"], ["core", "choosing"]) else parts[0]


def rooms_imported_by(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "mossar_stream":
            below = [f"{node.module}.{name.name}" for name in node.names]
            yield from (
                room_of(module if "." not in node.module or module.endswith("kernels") else node.module)
                for module in below
            )


def test_rooms_import_nothing_from_a_floor_above():
    modules = {
        path: ".".join(("mossar_stream", *path.relative_to(CORE).with_suffix("").parts))
        for path in CORE.rglob("*.py")
        if path != CORE / "__init__.py"
    }
    assert set(map(room_of, modules.values())) == set(FLOORS)
    upward = {
        f"{module}: {room}"
        for path, module in modules.items()
        for room in rooms_imported_by(path)
        if FLOORS.get(room, 9) > FLOORS[room_of(module)]
    }
    assert not upward
