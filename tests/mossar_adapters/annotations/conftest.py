"""Real recordings beside the project."""

from pathlib import Path

import pytest


@pytest.fixture
def shared_data() -> Path:
    """Return the folder of real recordings."""
    folder = Path(__file__).parents[4] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"the real recordings are not here ({folder})")
    return folder
