"""Unintended copies of records: `found = curve.found` copies, `found = &curve.found` does not.

    python -m checks.record_copies

Data written into such a copy is lost, without a message. No function of the core may therefore have a record as a local
variable or take one by value; the C that Cython writes shows each. A struct that holds a pointer is no record but a view: a
span, the arrays of a row; it is a value everywhere, as a tuple is. ALLOWED names the other intended copies.
Ends with status 1 if there is another one.
"""

import re
import sys
from collections.abc import Iterator

from build_core.extensions import run_each, variants, work_folder

# A struct that is a value everywhere, and never part of a row; or one variable: `function.variable`.
ALLOWED = {
    "Point",  # of a message
    "Features",  # of a candidate, made for the measure
    "Block",  # the path sum's own, on the stack
    "BlockSum",
    "PathState",
    "Search",
    "Twins",
    "Vertex",
    "_move_head.head",  # heads of stores that are not there yet, to find their sizes
    "move_memory_bytes.head",
    "move_memory_parts.head",
    "move_store_bytes.head",
    "follow_bank_bytes.head",
    "pose_bank_bytes.head",
}
FUNCTION = re.compile(r"^(?:static|extern|__PYX_EXTERN_C|CYTHON_\w+) .*?\b__pyx_\w+\(.*\{")
HELD = re.compile(
    r"(?:^  |[(,] ?)(?:CYTHON_UNUSED )?(?:struct )?(?P<type>\w+) __pyx_v_(?P<variable>\w+)\b(?!\[)"
)
STRUCT = re.compile(r"^struct (\w+) \{\n(.*?)^\};", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"int|long|short|char|double|float|size_t|u?int\w*_t|Py_\w+|npy_\w+|Py_UCS4|PyObject")


def records(c: str) -> set[str]:
    """Return the structs, by their names in C, that hold no pointer and no struct that holds one."""
    members = {
        name: re.sub(r"\[.*?\]", "", body) for name, body in STRUCT.findall(c) if name.startswith("__pyx_t_")
    }
    views = {name for name, body in members.items() if "*" in body}
    while more := {
        name for name in members.keys() - views if views & set(re.findall(r"struct (\w+)", members[name]))
    }:
        views |= more
    return members.keys() - views


def copies(c: str, module: str) -> Iterator[tuple[str, str, str]]:
    """Find locals and arguments that are structs, in the C of an extension; an array of structs is no copy of one.

    Args:
        c: Cython's output.
        module: The full name of the extension, which stands before each name.

    Yields:
        The function, the variable, and the struct's name, as the sources have them.
    """
    prefix = "_".join(f"{len(part)}{part}" for part in module.split(".")) + "_"
    structs = records(c)
    function = ""
    for line in c.splitlines():
        if FUNCTION.match(line):
            name = re.findall(r"\b__pyx_\w+(?=\()", line)[0].rpartition(prefix)[2]
            function = re.sub(r"^\d+", "", name)  # Cython counts the functions that Python sees
        elif not line.startswith("  "):
            continue
        for held in HELD.finditer(line):
            kind = held["type"]
            is_other = kind.startswith("__pyx_") and kind not in structs
            if not is_other and not NUMBER.fullmatch(kind):
                yield function, held["variable"], kind.removeprefix(f"__pyx_t_{prefix}")


def main() -> int:
    """Print each copy of a record, and return whether there was one."""
    variant = variants()[0]
    run_each([["--only-c", variant]])
    c = (work_folder(variant) / f"{variant}.c").read_text(encoding="utf-8")
    used = set()
    wrong = 0
    for function, variable, record in sorted(set(copies(c, f"mossar_stream.core.{variant}"))):
        allowed = ALLOWED & {record, f"{function}.{variable}"}
        used |= allowed
        if not allowed:
            wrong += 1
            print(f"{function}: {variable} is a copy of a {record}: take its address, or name it in ALLOWED")
    for name in sorted(ALLOWED - used):
        print(f"ALLOWED names {name}, which nothing copies")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
