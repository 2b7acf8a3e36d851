"""Regular files: files that are read whole must end; reading a pipe without a writer would never return."""

import errno
import os
from pathlib import Path


def check_regular(path: Path) -> None:
    """Refuse a pipe or a device, and a name that no file can have.

    Raises:
        OSError: If it is one; `strerror` has the reason. A file that is missing, and a folder, are left to the caller's `open`.
    """
    try:
        other = path.exists() and not (path.is_file() or path.is_dir())
    except ValueError as error:  # NUL in the name
        raise OSError(errno.EINVAL, str(error), os.fspath(path)) from None
    if other:
        raise OSError(errno.EINVAL, "this is a pipe or a device, not a file", os.fspath(path))
