"""Label Studio and templates of ELAN: predictions that its own library accepts, and that are read back."""

import json
from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.annotations.label_studio import write_label_studio
from mossar_adapters.annotations.reading import read_annotations
from mossar_adapters.annotations.tiers import Mark, Tier
from mossar_adapters.annotations.writing import write_annotations

TIERS = [
    Tier("segments motion", (Mark(0.0, 1.2, "resting"), Mark(1.2, 2.0, 'moving "a" & b'))),
    Tier("left_arm repetitions", (Mark(0.4, 0.8, "1"),)),
    Tier("key frames", (Mark(1.2, 1.2, "onset"),), moments=True),
]
TIMES = 50 + np.arange(101) / 50
POSITIONS = np.cumsum(np.ones((101, 2, 3)), axis=0) / 100


@pytest.mark.parametrize("video", [None, "/data/walk.mp4"])
def test_predictions_are_read_back_and_accepted_by_label_studio(tmp_path: Path, video: str | None) -> None:
    tasks, interface = tmp_path / "take.json", tmp_path / "take.xml"
    for path in (tasks, interface):
        write_label_studio(path, TIERS, TIMES, POSITIONS, video, 25.0)
    assert read_annotations(tasks) == TIERS
    (task,) = json.loads(tasks.read_text())
    if video is None:
        assert task["data"]["ts"]["time"][-1] == pytest.approx(2.0, abs=0.05)
        assert task["data"]["ts"]["speed"][5] == pytest.approx(3**0.5 / 2, rel=0.01)
    sdk = pytest.importorskip("label_studio_sdk.label_interface")
    known = sdk.LabelInterface(interface.read_text())
    assert known.validate_prediction(task["predictions"][0])


def test_what_a_person_corrected_takes_precedence_over_predictions(tmp_path: Path) -> None:
    path = tmp_path / "take.json"
    write_label_studio(path, TIERS, TIMES, POSITIONS)
    (task,) = json.loads(path.read_text())
    result = {"from_name": "moves", "value": {"start": 0.5, "end": 0.75, "timeserieslabels": ["jump"]}}
    path.write_text(json.dumps([{**task, "annotations": [{"result": [result]}]}]))
    assert read_annotations(path) == [Tier("moves", (Mark(0.5, 0.75, "jump"),))]


def test_templates_of_elan_have_the_tiers_and_their_words(tmp_path: Path) -> None:
    elan = pytest.importorskip("pympi").Elan
    path = tmp_path / "take.etf"
    write_annotations(path, TIERS, 2.0)
    document = elan.Eaf(str(path))
    assert set(document.get_tier_names()) == {tier.name for tier in TIERS}
    assert all(not document.get_annotation_data_for_tier(tier.name) for tier in TIERS)
    words = document.get_cv_entries("words of segments motion")
    assert [entry[0][0][0] for entry in words.values()] == ["resting", 'moving "a" & b']
