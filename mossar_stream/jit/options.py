"""Options that kernels are compiled with."""

from typing import Any

from mossar_stream.jit.inner import InnerCompiler

# No fastmath: it gains nothing here, and it permits dropping NaN checks and reordering sums, which breaks the
# frame-for-frame equality with the reference.
_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "forceinline": False,  # stated, because callees inherit what is not
}


def inner_options(*, inline: bool = False, returns_views: bool = False) -> dict[str, Any]:
    """Return the options of a kernel that only kernels call.

    Args:
        inline: Whether LLVM is to copy it into its callers.
        returns_views: Whether numba is to do that before anything is compiled.
    """
    return {
        **_OPTIONS,
        "forceinline": inline and not returns_views,
        "inline": "always" if returns_views else "never",
        "no_cpython_wrapper": True,
        "pipeline_class": InnerCompiler,
    }


def entry_options(*, makes_arrays: bool) -> dict[str, Any]:
    """Return the options of a kernel that Python calls.

    Args:
        makes_arrays: Whether it, or a kernel that it calls other than by name, makes arrays.
    """
    return dict(_OPTIONS) if makes_arrays else {**_OPTIONS, "_nrt": False}  # callees inherit it
