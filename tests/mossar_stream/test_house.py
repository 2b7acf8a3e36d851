"""What holds for the house as a whole: its face, its floors, and what its kernels may take."""

import ast
from pathlib import Path

import pytest

import mossar_stream
from checks import pxi

CORE = Path(mossar_stream.__file__).parent
ROOT = CORE.parent
COMPILED = ("mossar_stream.core.kernels", "mossar_stream.core.choosing")
MOST_PARAMETERS = 8  # an array without a record of its own counts twice: where it lies, and how long it is


def files(folder):
    return sorted(folder.rglob("*.py"))


def tree_of(file):
    return ast.parse(file.read_text(encoding="utf-8"))


def imported_by(file, *, package="mossar_stream"):
    """Return the modules of a package that a file imports, wherever in it."""
    for node in ast.walk(tree_of(file)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == package:
            for name in node.names:
                below = f"{node.module}.{name.name}"
                yield below if path_of(below) else node.module
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.partition(".")[0] == package)


def path_of(module):
    base = ROOT.joinpath(*module.split("."))
    return next((p for p in (base.with_suffix(".py"), base / "__init__.py") if p.exists()), None)


def test_the_public_face_is_what_dir_shows_and_all_of_it_is_there():
    assert set(dir(mossar_stream)) == {*mossar_stream.__all__, "__version__"}
    for name in mossar_stream.__all__:
        assert getattr(mossar_stream, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'Segmentor'"):
        _ = mossar_stream.Segmentor


def test_what_public_functions_hand_out_is_public():
    events = ("KeyFrameEvent", "SegmentEvent", "StreamEvent", "StatsEvent")
    results = ("Result", "Segmentation", "KeyFrame", "Segment", "CurveState")
    settings = ("Settings", "ResolvedSettings", "Features", "VarianceFloor", "LevelName")
    assert {*events, *results, *settings} <= set(mossar_stream.__all__)


@pytest.mark.parametrize("folder", ["adapters", "tools/mossar_tools", "tools/checks", "examples"])
def test_nobody_outside_imports_deeper_than_the_public_face(folder):
    # The stopwatches, the oracles of tests, the program that fits the weights, and the paper's recursion stand within the
    # core, as tests do.
    within = ("checks/speed", "checks/leave_out", "checks/reference", "checks/paper/comparison")
    own = [file for file in files(ROOT / folder) if not any(name in file.as_posix() for name in within)]
    deep = {
        f"{file.relative_to(ROOT)}: {module}"
        for file in own
        for module in imported_by(file)
        if module != "mossar_stream"
    }
    assert deep == set()


def circle_in(graph):
    """Return a circle of a graph, or nothing."""
    done, trail = set(), []

    def visit(node):
        if node in trail:
            return trail[trail.index(node) :]
        if node in done:
            return []
        done.add(node)
        trail.append(node)
        found = next(filter(None, map(visit, sorted(graph.get(node, ())))), [])
        trail.pop()
        return found

    return next(filter(None, map(visit, sorted(graph))), [])


def test_circles_are_found():
    assert circle_in({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c"]
    assert not circle_in({"a": {"b", "c"}, "b": {"c"}, "c": set()})


def name_of(file):
    return ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def part_of(module, depth):
    """Return the part of the house that a module belongs to: the compiled core is one of its own."""
    return COMPILED[0] if module in COMPILED else ".".join(module.split(".")[:depth])


@pytest.mark.parametrize("depth", [2, 9], ids=["rooms", "modules"])
def test_no_import_goes_round_in_a_circle(depth):
    graph = {}
    for file in files(CORE):
        own = part_of(name_of(file), depth)
        others = {part_of(module, depth) for module in imported_by(file)}
        if file != CORE / "__init__.py":  # the face, which imports everything when it is asked for
            graph.setdefault(own, set()).update(others - {own, "mossar_stream"})
    assert len(graph) > 10
    assert not circle_in(graph)


def test_kernels_take_at_most_eight_parameters():
    kernels = [
        (file.name, function)
        for file in sorted(CORE.rglob("*.pxi"))
        if file.name != "testing.pxi"
        for function in pxi.functions(file.read_text(encoding="utf-8"))
    ]
    assert len(kernels) > 100
    assert not [
        (name, function.name) for name, function in kernels if len(function.parameters) > MOST_PARAMETERS
    ]
