"""Numba's cache on disk, so that damage to it, or no room for it, costs time and nothing else."""

import contextlib

from numba.core.caching import FunctionCache


class SturdyCache(FunctionCache):
    """Numba's cache, without which everything works, too, but for the time it takes to compile.

    A power cut leaves files empty or cut off, and a disk may be full; numba would let neither pass.
    """

    def load_overload(self, sig: object, target_context: object) -> object:
        """Return a kernel for a signature, None if there is none that can be read."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001 - damaged pickles raise anything
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: object, data: object) -> None:
        """Keep a kernel if there is room for it."""
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)
