"""Annotated recordings: what a person corrected by hand is scored with."""

import itertools
import json

import numpy as np
import pytest

from mossar_adapters.annotations.tiers import AnnotationError, Mark, Tier
from mossar_adapters.annotations.writing import write_annotations
from mossar_tools.evaluation.annotated import annotated_cuts
from mossar_tools.evaluation.labels import LabelError
from mossar_tools.evaluation.takes import load_folder

TIMES = 100 + np.arange(301) / 30  # 10 s


def written(path, *tiers):
    if path.suffix in {".eaf", ".TextGrid"}:
        pytest.importorskip("pympi")
    write_annotations(path, tiers, 10.0)
    return path


def stretches(name, *spans):
    return Tier(name, tuple(Mark(start, end, "a") for start, end in spans))


def middles(path, wanted=None, level="motion"):
    return [cut.middle for cut in annotated_cuts(path, wanted, level, TIMES, 0.25)]


@pytest.mark.parametrize("suffix", [".eaf", ".TextGrid", ".txt"])
def test_boundaries_of_segments_are_cuts_but_for_the_ends_of_the_recording(tmp_path, suffix):
    path = written(tmp_path / f"walk{suffix}", stretches("segments", (0, 2), (2, 5), (5, 10)))
    assert middles(path) == [102, 105]


def test_the_tier_of_the_level_is_taken_first(tmp_path):
    tiers = [stretches("segments", (0, 2)), stretches("segments cluster", (0, 5)), stretches("mine", (0, 7))]
    path = written(tmp_path / "walk.txt", *tiers)
    assert [middles(path), middles(path, level="cluster"), middles(path, "mine")] == [[102], [105], [107]]
    with pytest.raises(AnnotationError, match="no tier called yours; there are: segments"):
        middles(path, "yours")


def test_an_end_and_a_near_begin_are_one_cut(tmp_path):
    path = written(tmp_path / "walk.txt", stretches("moves", (1, 2), (2.2, 5), (6, 7)))
    found = annotated_cuts(path, None, "motion", TIMES, 0.25)
    assert [(c.earliest, c.latest) for c in found] == [
        pytest.approx(own) for own in [(101, 101), (102, 102.2), (105, 105), (106, 106), (107, 107)]
    ]


def test_moments_are_cuts(tmp_path):
    moments = Tier("key frames", (Mark(1, 1, "onset"), Mark(3, 3, "offset")), moments=True)
    assert middles(written(tmp_path / "walk.txt", moments)) == [101, 103]


def test_an_annotation_beside_a_recording_is_its_label(labelled):
    (before,) = load_folder(labelled)
    edges = [0.0, *(cut.middle for cut in before.cuts), before.duration]
    (labelled / "walk.json").unlink()
    written(labelled / "walk.txt", stretches("segments", *itertools.pairwise(edges)))
    (take,) = load_folder(labelled)
    assert [cut.middle for cut in take.cuts] == pytest.approx([cut.middle for cut in before.cuts], abs=1e-5)
    assert take.level == "motion"


def test_an_export_of_label_studio_beside_a_recording_is_its_label(labelled):
    spans = [{"value": {"start": s, "end": s + 1, "timeserieslabels": ["a"]}} for s in (1, 2)]
    (labelled / "walk.json").write_text(json.dumps([{"annotations": [{"result": spans}]}]))
    (take,) = load_folder(labelled)
    assert [cut.middle for cut in take.cuts] == [1, 2, 3]


def test_a_label_file_may_name_annotations_and_a_tier(relabel):
    folder = relabel(annotations="by_hand.txt", tier="steps", level="cluster")
    written(folder / "by_hand.txt", stretches("steps", (0, 1)), stretches("segments", (0, 2)))
    (take,) = load_folder(folder)
    assert ([cut.middle for cut in take.cuts], take.level) == ([1.0], "cluster")
    with pytest.raises(LabelError, match=r"by_hand.*which is not in"):
        load_folder(relabel(annotations="by_hand.eaf"))


def test_texts_without_a_recording_are_passed_over(labelled):
    (labelled / "README.txt").write_text("what is here\n")
    assert len(load_folder(labelled)) == 1
