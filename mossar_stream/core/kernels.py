"""What the chosen core offers; `kernels.pyi` has the signatures."""

from mossar_stream.core.choosing import chosen_core

_core = chosen_core()
globals().update(
    {name: value for name, value in vars(_core).items() if not name.startswith("_")}
    | _core.CONSTANTS
    | _core.TESTED_CONSTANTS
)
