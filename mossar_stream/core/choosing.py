"""Choice of the compiled core for this process.

On x86-64 the core is compiled twice, and the wider one is taken where the processor runs it. `MOSSAR_CORE=baseline` or
`MOSSAR_CORE=x86_64_v3` takes that one. A core that is missing, or older than the sources beside it, is an ImportError: Python
code that stands in for it would give the same events, some hundred times slower, without a message.
"""

import os
import zlib
from importlib import import_module
from types import ModuleType

HOME = os.path.dirname(__file__)  # noqa: PTH120 - pathlib is loaded in 5 ms
VARIANTS = ("baseline", "x86_64_v3")
WISH = "MOSSAR_CORE"


def chosen_core() -> ModuleType:
    """Return the compiled core for this machine.

    Raises:
        ImportError: It is missing, older than its sources, or the wish cannot be met; the message is one line.
    """
    wish = os.environ.get(WISH, "")
    if wish and wish not in VARIANTS:
        raise ImportError(f"{WISH}={wish}: there are {' and '.join(VARIANTS)}", name=__package__)
    baseline = _loaded("baseline")
    is_wider = baseline.has_x86_64_v3()
    if wish == "x86_64_v3" and not is_wider:
        raise ImportError(f"{WISH}={wish}: this processor does not run x86-64-v3", name=__package__)
    core = _loaded("x86_64_v3") if is_wider and wish != "baseline" else baseline
    changed = _changed(core.BUILT_FROM)
    if changed:
        raise ImportError(
            f"{core.__name__} is older than {changed}: run `python -m build_core` or `pip install -e .`",
            name=core.__name__,
        )
    return core


def _loaded(variant: str) -> ModuleType:
    """Return a compiled core, if it is there."""
    name = f"{__package__}.{variant}"
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise ImportError(
            f"{name} was not compiled for this Python: run `pip install -e .` in a checkout, or install a wheel",
            name=name,
        ) from None


def _changed(built_from: str) -> str | None:
    """Return a source that differs from the one that the core was compiled from; wheels hold no sources.

    The contents are compared, since a checkout sets the time of each file anew: some 400 kB, in less than a millisecond.
    """
    if not os.path.exists(f"{HOME}/core.pxi"):  # noqa: PTH110
        return None
    for line in built_from.splitlines()[1:]:
        checksum, _, source = line.partition(" ")
        try:
            with open(f"{HOME}/../{source}", "rb") as file:  # noqa: PTH123
                if zlib.crc32(file.read()) == int(checksum, 16):
                    continue
        except FileNotFoundError:
            pass
        return f"mossar_stream/{source}"
    return None
