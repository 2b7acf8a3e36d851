"""Functions of the chosen core; `kernels.pyi` has the signatures."""

from mossar_stream.core.choosing import chosen_core

_core = chosen_core()
globals().update(
    {name: value for name, value in vars(_core).items() if getattr(value, "__module__", "") == _core.__name__}
    | {name: getattr(_core, name) for name in ("BUILT_FROM", "RECORDS", "CONSTANTS", "TESTED_CONSTANTS")}
    | _core.CONSTANTS
    | _core.TESTED_CONSTANTS
)
