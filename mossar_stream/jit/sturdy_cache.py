"""Numba's cache on disk, so that damage to it, or no room for it, costs time and nothing else."""

import contextlib
import hashlib
from pathlib import Path
from types import FunctionType

from numba.core.caching import FunctionCache, IndexDataCacheFile

from mossar_stream.jit.sources import PACKAGE


class SturdyCache(FunctionCache):
    """Numba's cache, without which everything works, too, but for the time it takes to compile.

    A power cut leaves files empty or cut off, and a disk may be full; numba would let neither pass. Nor would it notice
    that two processes, which compile a kernel for different types at once, call their files alike: one would then run
    the other one's code.
    """

    def __init__(self, py_func: FunctionType) -> None:
        super().__init__(py_func)
        impl = self._impl
        name, stamp = impl.filename_base, impl.locator.get_source_stamp()
        if Path(py_func.__code__.co_filename).is_relative_to(PACKAGE):
            # The folder is named after the contents: neither the time of the file nor the line counts.
            name, stamp = name.replace(f"-{impl.locator.get_disambiguator()}.py", ".py"), None
        self._cache_file = _OneNameEach(self._cache_path, name, stamp)

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


class _OneNameEach(IndexDataCacheFile):
    """Files whose names follow from the types they were compiled for, not from how many there were before."""

    def save(self, key: object, data: object) -> None:
        """Write a kernel, then say in the index where it is; who writes the index at the same time may win."""
        number = int.from_bytes(hashlib.sha256(repr(key).encode()).digest()[:7])
        name = self._data_name(number)
        self._save_data(name, data)
        self._save_index({**self._load_index(), key: name})
