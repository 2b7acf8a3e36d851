"""Lines of coordinates, padded with zeros so that many are multiplied at once."""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel
from mossar_stream.jit.simd import FACTORS, line_product


def padded(count: int) -> int:
    """Return how many numbers `count` of them take with their padding."""
    return -(-count // FACTORS) * FACTORS


@inline_kernel
def scale_to_one(line):
    """Give a padded line the length 1 and return the length it had; a line of zeros stays."""
    length = np.sqrt(line_product(line, line))
    if length > 0.0:
        factor = np.float32(1.0) / length
        for i in range(line.size):
            line[i] *= factor
    return length
