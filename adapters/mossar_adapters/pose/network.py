"""One network: a LiteRT interpreter that takes a picture and returns its outputs by their shapes."""

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.extras import needed
from mossar_adapters.pose.types import PoseError

# One thread: two raise the rate by half and the share of the machine more, and the segmenter needs a core, too.
THREADS: Final = 1


class Network:
    """A network of the maker's, ready to run.

    Args:
        path: A `.tflite` file.
        threads: That it may use.

    Attributes:
        side: Pixels of the square picture that it takes.

    Raises:
        PoseError: If the file cannot be used.
    """

    def __init__(self, path: Path, threads: int = THREADS) -> None:
        needed("ai_edge_litert", "webcam", "estimating poses from pictures")
        from ai_edge_litert.interpreter import Interpreter

        try:
            with _standard_error_off():
                self._interpreter = Interpreter(model_path=str(path), num_threads=threads)
                self._interpreter.allocate_tensors()
        except (ValueError, RuntimeError) as error:
            raise PoseError(f"{path}: cannot be used as a network: {' '.join(str(error).split())}") from None
        (taken,) = self._interpreter.get_input_details()
        self._taken = int(taken["index"])
        self._given: dict[tuple[int, ...], int] = {
            tuple(int(n) for n in given["shape"]): int(given["index"])
            for given in self._interpreter.get_output_details()
        }
        self.side = int(taken["shape"][1])

    def run(self, picture: NDArray[np.float32]) -> None:
        """Estimate.

        Args:
            picture: (side, side, 3), RGB, in the range that the network was trained on.
        """
        self._interpreter.set_tensor(self._taken, picture[None])
        self._interpreter.invoke()

    def output(self, *shape: int) -> NDArray[Any]:
        """Return a copy of the output of this shape, without the batch of one: pass (a, b) for (1, a, b)."""
        found: NDArray[Any] = self._interpreter.get_tensor(self._given[1, *shape])
        first: NDArray[Any] = found[0]
        return first


@contextlib.contextmanager
def _standard_error_off() -> Iterator[None]:
    """Discard the runtime's output to standard error: it reports its start there under all settings."""
    try:
        kept = os.dup(2)
    except OSError:  # standard error is closed
        yield
        return
    try:
        sys.stderr.flush()
        with open(os.devnull, "wb") as nowhere:  # noqa: PTH123 - a device
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
