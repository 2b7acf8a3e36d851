"""A labelled folder made of the built-in performer, and the labelled recordings where they are."""

import json
from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.demo import performance

LABELLED = Path(__file__).parents[4] / "shared" / "data" / "labelled"


@pytest.fixture
def labelled(tmp_path):
    """Return a folder with one labelled recording, `walk.npz` with `walk.json`."""
    take = performance(3, moves=("rest", "punch_left", "kick_right", "rest"), fps=30)
    np.savez(
        tmp_path / "walk.npz",
        positions=take.frames.positions,
        fps=30.0,
        joint_names=np.array(take.skeleton.names),
        parents=np.array(take.skeleton.parents),
    )
    label(tmp_path, cuts=[[cut.frame] * 3 for cut in take.cuts])
    return tmp_path


@pytest.fixture
def relabel(labelled):
    """Write another label file for the recording of the labelled folder; returns the folder."""

    def write(**fields):
        label(labelled, **fields)
        return labelled

    return write


def label(folder, **fields):
    content = {"recording": "walk.npz", "fps": 30, "tolerance_s": 0.25, "level": "motion", **fields}
    (folder / "walk.json").write_text(json.dumps({k: v for k, v in content.items() if v is not None}))


@pytest.fixture
def recordings():
    """Return the folder of labelled recordings."""
    if not LABELLED.is_dir():
        pytest.skip("no labelled recordings in ../shared/data/labelled")
    return LABELLED
