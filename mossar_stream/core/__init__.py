"""The compiled core: records, the functions that write them, and the loop over frames.

`core.pxi` is the whole of it; it includes the other files in the order of the data. `python -m build_core` compiles it, on
x86-64 once for every processor (`baseline.pyx`) and once for those with AVX2 (`x86_64_v3.pyx`). `kernels` is the one of the two
that suits this machine; `kernels.pyi` lists its functions.
"""
