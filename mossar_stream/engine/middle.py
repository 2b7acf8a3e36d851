"""Middle: the centroid of a performer's joints, on which limbs hang where the skeleton has no root.

The body's own centroid is taken: joints that are missing or too far off are held as the body holds them, and then carried
along. A mean of the joints that are there would move whenever a joint goes or comes.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.row import ROW
from mossar_stream.jit.decorators import entry_point, inline_kernel
from mossar_stream.jit.views import part
from mossar_stream.memory.joint_pages import center_of


@inline_kernel
def put_middle(body: NDArray[np.uint8], middle: NDArray[np.float32]) -> None:
    """Set the middle of the joints of the frame that the body processed last.

    Args:
        body: Bytes of the performer.
        middle: (3,) m, set; NaN if no joint was there.
    """
    whole = part(body, 0, ROW, (1,))[0]
    lines = part(body, whole.at.body, np.float32, ((whole.at.seen - whole.at.body) // 4,))
    x, y, z = center_of(whole.plan, whole.joints, lines)  # type: ignore[no-untyped-call]
    nobody = whole.joints.present == 0
    middle[0] = np.float32(np.nan) if nobody else x
    middle[1] = np.float32(np.nan) if nobody else y
    middle[2] = np.float32(np.nan) if nobody else z


@entry_point(makes_arrays=False)
def set_middle(body: NDArray[np.uint8], middle: NDArray[np.float32]) -> None:
    """Do the same from Python."""
    put_middle(body, middle)
