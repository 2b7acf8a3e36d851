"""Compiles the core: Cython to C, C to the extensions that lie in `mossar_stream/core`.

    python -m build_core              # outdated extensions, in place; a minute
    python -m build_core --force      # all of them
    python -m build_core --quick      # in half the time: the same results, but the core is slower; to try a change
    python -m build_core --strict     # warnings of Cython and of the C compiler are errors
    python -m build_core --sanitize   # with checks of addresses and of undefined behaviour: see checks.sanitized

`pip install` does the same by `hook.py`. The switches exist as variables for it, too: MOSSAR_STRICT=1, MOSSAR_SANITIZE=1.
The compiler is CC, else the one Python was built with, else `cc`; where there is none, zig from PyPI (`ziglang`).
"""
