"""What the core is compiled from, and which extension was compiled from what."""

import zlib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "mossar_stream"
ENDINGS = {".pyx", ".pxi", ".pxd", ".h"}
MARK = "mossar core"


def sources() -> list[Path]:
    """Return every source of the core; which of them includes which does not matter, since all make one extension."""
    return sorted(path for path in PACKAGE.rglob("*") if path.suffix in ENDINGS)


def built_from(compiler: str, recipe: str) -> str:
    """Return what an extension says of itself: a line with the compiler and the recipe's checksum, then one for each source.

    Args:
        compiler: The name of its program.
        recipe: Everything else that changes the result: flags, versions.
    """
    checksums = [
        f"{zlib.crc32(path.read_bytes()):08x} {path.relative_to(PACKAGE).as_posix()}" for path in sources()
    ]
    return "\n".join([f"{MARK} {compiler} {zlib.crc32(recipe.encode()):08x}", *checksums])


def as_header(text: str) -> str:
    """Return the text as a constant in C."""
    lines = "\n".join(f'    "{line}\\n"' for line in text.splitlines())
    return f"/* Written by build_core. */\nstatic const char MOSSAR_BUILT_FROM[] =\n{lines};\n"


def is_built_from(extension: Path, text: str) -> bool:
    """Return whether an extension is there and holds this text; it need not be loaded for that."""
    return extension.exists() and f"{text}\n".encode() in extension.read_bytes()
