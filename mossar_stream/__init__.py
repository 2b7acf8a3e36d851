"""Streaming Mossar: reports, live, where one human motion ends and the next begins.

The public names stand once, in `__init__.pyi`. They are loaded when they are first used, so that `mossar --help` loads neither
numpy nor the core.
"""

import ast
import pkgutil
from importlib import import_module

__version__ = "0.2.0"


def _homes() -> dict[str, str]:
    """Return the module of each public name, from the stub."""
    stub = ast.parse(pkgutil.get_data(__name__, "__init__.pyi") or b"")
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: node.module or "" for node in imports for alias in node.names}


_HOMES = _homes()
__all__ = sorted(_HOMES)  # noqa: PLE0605 - a list


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
