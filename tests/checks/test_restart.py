import os
from pathlib import Path

import pytest

from checks import restart

ROOT = Path(__file__).parents[2]


@pytest.mark.skipif(os.name != "posix", reason="kill -9 is of POSIX systems")
def test_runs_killed_at_random_moments_go_on_as_if_nothing_had_happened(tmp_path, monkeypatch):
    places = [ROOT, ROOT / "adapters", ROOT / "tools"]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(str, places)))
    moments = []
    for moment in restart.killed_at_random(tmp_path, times=20, seconds=40.0, seed=4):
        moments.append(moment)
        # A busy machine may start so slowly that the first ones come before any snapshot.
        if len(moments) >= 3 and {moment.lost is None for moment in moments if moment.frames} == {
            True,
            False,
        }:
            break
    assert all(moment.right for moment in moments)
    assert any(moment.lost is not None for moment in moments)
    assert any(moment.frames for moment in moments)
