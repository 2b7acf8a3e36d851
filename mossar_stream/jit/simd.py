"""Sums and products over many joints at once, in an order that does not depend on the machine.

On the accelerated path they are instructions written by hand, on the plain one their twins in Python.
"""

from importlib import import_module
from typing import Any

from mossar_stream.jit.acceleration import is_accelerated
from mossar_stream.jit.simd_twin import FACTORS, WIDTH

_chosen: Any = import_module(f"mossar_stream.jit.{'instructions' if is_accelerated() else 'simd_twin'}")

page_sum = _chosen.page_sum
page_product = _chosen.page_product
line_product = _chosen.line_product
page_within = _chosen.page_within
spread_product = _chosen.spread_product
variance_product = _chosen.variance_product
lowest_bit = _chosen.lowest_bit

__all__ = [
    "FACTORS",
    "WIDTH",
    "line_product",
    "lowest_bit",
    "page_product",
    "page_sum",
    "page_within",
    "spread_product",
    "variance_product",
]
