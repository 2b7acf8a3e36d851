"""The sources of the core, the state of each extension, and the declarations of records for Python."""

import re
import zlib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "mossar_stream"
ENDINGS = {".pyx", ".pxi", ".pxd", ".h"}
MARK = "mossar core"
STRUCT = re.compile(r"^cdef struct (\w+):.*\n((?:(?: {4}.*)?\n)+)", re.MULTILINE)
MEMBER = re.compile(r"\w+ \w+(?:\[\d+\])*")


def sources() -> list[Path]:
    """Return every source of the core; which of them includes which does not matter, since all make one extension."""
    return sorted(path for path in PACKAGE.rglob("*") if path.suffix in ENDINGS)


def built_from(compiler: str, recipe: str) -> str:
    """Return the state of an extension: a line with the compiler and the recipe's checksum, then one for each source.

    Args:
        compiler: The name of its program.
        recipe: Everything else that changes the result: flags, versions.
    """
    checksums = [
        f"{zlib.crc32(path.read_bytes()):08x} {path.relative_to(PACKAGE).as_posix()}" for path in sources()
    ]
    return "\n".join([f"{MARK} {compiler} {zlib.crc32(recipe.encode()):08x}", *checksums])


def records() -> str:
    """Return the members of each struct that holds numbers and such structs: a line each, of which Python makes numpy types."""
    declared = []
    for path in sources():
        for name, body in STRUCT.findall(path.read_text(encoding="utf-8")):
            lines = [line.partition("#")[0].strip() for line in body.splitlines()]
            members = [line for line in lines if line]
            if all(MEMBER.fullmatch(member) for member in members):
                declared.append(f"{name} {'; '.join(members)}")
    return "\n".join(declared)


def as_header(constants: dict[str, str]) -> str:
    """Return texts as constants in C, by their names."""
    header = "/* Written by build_core. */\n"
    for name, text in constants.items():
        lines = "\n".join(f'    "{line}\\n"' for line in text.splitlines())
        header += f"static const char {name}[] =\n{lines};\n"
    return header


def is_built_from(extension: Path, text: str) -> bool:
    """Return whether an extension is there and holds this text; it need not be loaded for that."""
    return extension.exists() and f"{text}\n".encode() in extension.read_bytes()
