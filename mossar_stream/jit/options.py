"""Options that kernels are compiled with."""

from typing import Any

# No fastmath: it gains nothing here, and it permits dropping NaN checks and reordering sums, which breaks the
# frame-for-frame equality with the reference.
_PLAIN: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
_ACCELERATED: dict[str, Any] = {
    **_PLAIN,
    "no_cfunc_wrapper": True,
    "forceinline": False,  # said, because callees inherit what is not
}


def inner_options(*, accelerated: bool, inline: bool = False, returns_views: bool = False) -> dict[str, Any]:
    """Return the options of a kernel that only kernels call.

    Args:
        accelerated: Which path; see acceleration.py.
        inline: Whether LLVM is to copy it into its callers.
        returns_views: Whether numba is to do that before anything is compiled.
    """
    if not accelerated:
        return {**_PLAIN, "inline": "always" if returns_views else "never"}
    from mossar_stream.jit.inner import InnerCompiler  # noqa: PLC0415 - stands on numba's private parts

    return {
        **_ACCELERATED,
        "forceinline": inline and not returns_views,
        "inline": "always" if returns_views else "never",
        "no_cpython_wrapper": True,
        "pipeline_class": InnerCompiler,
    }


def entry_options(*, accelerated: bool, makes_arrays: bool) -> dict[str, Any]:
    """Return the options of a kernel that Python calls.

    Args:
        accelerated: Which path.
        makes_arrays: Whether it, or a kernel that it calls other than by name, makes arrays.
    """
    if not accelerated:
        return dict(_PLAIN)
    return dict(_ACCELERATED) if makes_arrays else {**_ACCELERATED, "_nrt": False}  # callees inherit it
