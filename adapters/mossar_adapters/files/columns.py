"""The columns of joints, confidence and time in a table, by their headings.

Understood are `hip.x`, `hip_x`, `hip x`, `hip:X`, `hipX`, `hip (x)`, `hip.pos.x`, `hip_tx`, `x_hip` and the like; a joint
counts only if it has all three axes. Axes may be numbers, in brackets or, where no heading names an axis, behind a separator.
"""

import re
from collections.abc import Sequence

import msgspec

_SEPARATOR = r"[\s._:/\-]*"
_LONG_RUN = re.compile(r"([\s._:/\-]{3})[\s._:/\-]+")  # longer runs would make the patterns slow
_AXIS_LAST = re.compile(
    rf"(?P<joint>.+?)(?:{_SEPARATOR}(?:(?:position|pos|translation|translate|trans){_SEPARATOR})?|[\s._:/\-]+t)"
    r"[(\[]?(?P<axis>[xyz])[)\]]?"
    rf"(?:{_SEPARATOR}[(\[]?(?:m|cm|mm)[)\]]?)?",
    re.IGNORECASE,
)
_AXIS_FIRST = re.compile(rf"(?P<axis>[xyz]){_SEPARATOR}(?P<joint>.+)", re.IGNORECASE)
_CONFIDENCE = re.compile(
    rf"(?P<joint>.+?){_SEPARATOR}(?:c|conf|confidence|score|visibility|likelihood)", re.IGNORECASE
)
_NUMBERED = re.compile(r"(?P<joint>.+?)\s*[\[(](?P<axis>[0-3])[\])]")
_BEHIND = re.compile(r"(?P<joint>.+?)(?:[\s._:/\-]+(?P<plain>[0-3])|\s*[\[(](?P<axis>[0-3])[\])])")
_ALIKE = 3  # joints whose numbers must be the same to be axes where no heading names an axis
_OTHER_VECTORS = re.compile(
    r"(?:^|[\s._:/\-])(?:q|quat|quaternion|rot|rotation|euler|angles?|ori|orientation|vel|velocity|acc|accel|"
    r"acceleration|gyro|mag|scale|offset|forces?|moments?)$",
    re.IGNORECASE,
)
_TIME = re.compile(
    r"(?:time|timestamps?|t|seconds|secs?|elapsed|elapsed_?time|date_?time)"
    r"[\s_.]*[(\[]?(?P<unit>seconds|secs?|s|msecs?|ms|milliseconds|us|microseconds|ns|nanoseconds)?[)\]]?",
    re.IGNORECASE,
)
_BODY = re.compile(
    r"(?:body|person|people|player|performer|subject|actor|user|skeleton|track(?:ing)?)"
    r"[\s_.]*(?:id|idx|index|no|number|name)?",
    re.IGNORECASE,
)
MAX_COLUMNS = 20_000
MAX_HEADING = 160  # characters; a longer text is no heading and would make the patterns slow
SECONDS = {"s": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9}


class Columns(msgspec.Struct, frozen=True):
    """Places of the columns in a row.

    Args:
        joints: Names.
        xyz: Column of x, y and z of each joint.
        confidence: Column of the confidence of each joint; empty if not all joints have one.
        time: Column of the time, -1 without.
        time_unit: Seconds per unit of time, if the heading has one.
        body: Column of the person, -1 without.
    """

    joints: tuple[str, ...]
    xyz: tuple[tuple[int, int, int], ...]
    confidence: tuple[int, ...] = ()
    time: int = -1
    time_unit: float | None = None
    body: int = -1


def find_columns(header: Sequence[str]) -> Columns | None:
    """Return the columns of the headings, or None if there is no joint among them."""
    if len(header) > MAX_COLUMNS:
        return None
    cells = _with_axes([_plain(cell) for cell in header])
    triples = _triples(cells, _AXIS_LAST) or _triples(cells, _AXIS_FIRST)
    if not triples:
        cells = _with_numbered_axes(cells)
        triples = _triples(cells, _AXIS_LAST)
    if not triples:
        return None
    found = {m["joint"]: i for i, cell in enumerate(cells) if (m := _CONFIDENCE.fullmatch(cell))}
    confidence = tuple(found[joint] for joint in triples) if set(triples) <= set(found) else ()
    time, unit = _time_column(cells)
    body = next((i for i, cell in enumerate(cells) if _BODY.fullmatch(cell)), -1)
    return Columns(tuple(triples), tuple(triples.values()), confidence, time, unit, body)


def _plain(cell: str) -> str:
    return _LONG_RUN.sub(r"\1", cell.strip().strip('"').strip()) if len(cell) <= MAX_HEADING else ""


def _with_axes(cells: list[str]) -> list[str]:
    """Return headings with `.x`, `.y`, `.z` for `[0]`, `[1]`, `[2]`, as tables of vectors number them; `[3]` is their 1."""
    numbered = [_NUMBERED.fullmatch(cell) for cell in cells]
    axes: dict[str, set[str]] = {}
    for match in filter(None, numbered):
        axes.setdefault(match["joint"], set()).add(match["axis"])
    return [
        f"{match['joint']}.{'xyz'[int(match['axis'])]}"
        if match and match["axis"] in "012" and axes[match["joint"]] >= {"0", "1", "2"}
        else cell
        for cell, match in zip(cells, numbered, strict=True)
    ]


def _with_numbered_axes(cells: list[str]) -> list[str]:
    """Return headings with `.x`, `.y`, `.z` for `_0`, `_1`, `_2`, or for 1, 2, 3, if all joints are numbered so."""
    numbered = [_BEHIND.fullmatch(cell) for cell in cells]
    axes: dict[str, str] = {}
    for match in filter(None, numbered):
        axes[match["joint"]] = axes.get(match["joint"], "") + (match["plain"] or match["axis"])
    ways = set(axes.values())
    if len(axes) < _ALIKE or len(ways) != 1 or not ways <= {"012", "123"}:
        return cells
    (way,) = ways
    return [
        f"{match['joint']}.{'xyz'[way.index(match['plain'] or match['axis'])]}" if match else cell
        for cell, match in zip(cells, numbered, strict=True)
    ]


def _triples(cells: Sequence[str], pattern: re.Pattern[str]) -> dict[str, tuple[int, int, int]]:
    axes: dict[str, dict[str, int]] = {}
    for i, cell in enumerate(cells):
        match = pattern.fullmatch(cell)
        if match and not _OTHER_VECTORS.search(match["joint"]):
            axes.setdefault(match["joint"], {}).setdefault(match["axis"].lower(), i)
    return {joint: (at["x"], at["y"], at["z"]) for joint, at in axes.items() if len(at) == 3}


def _time_column(cells: Sequence[str]) -> tuple[int, float | None]:
    for i, cell in enumerate(cells):
        if match := _TIME.fullmatch(cell):
            word = match["unit"] or ("s" if cell.lower().startswith("sec") else None)
            if word is None:
                return i, None
            milli = word.lower().startswith(("ms", "milli"))
            return i, SECONDS[
                "m"
                if milli
                else "u"
                if word[0] in "uU" or word.lower().startswith("micro")
                else "n"
                if word[0] in "nN"
                else "s"
            ]
    return -1, None
