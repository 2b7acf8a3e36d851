import numpy as np
import pytest

from mossar_tools.evaluation.judges import truth_from_judges


def test_judges_who_agree_give_their_cuts():
    cuts = truth_from_judges([[1.0, 4.0]] * 5)
    assert [cut.middle for cut in cuts] == pytest.approx([1.0, 4.0], abs=1e-3)
    assert [cut.earliest for cut in cuts] == pytest.approx([1.0, 4.0], abs=1e-3)
    assert [cut.latest for cut in cuts] == pytest.approx([1.0, 4.0], abs=1e-3)


def test_a_cut_reaches_from_its_earliest_to_its_latest_judgement():
    (cut,) = truth_from_judges([[1.9], [2.0], [2.2]])
    assert (cut.earliest, cut.latest) == (1.9, 2.2)
    assert 1.95 < cut.middle < 2.1


def test_a_maximum_of_few_judges_is_ignored():
    judgements = [[2.0, 5.0], [2.1], [1.9], [2.0]]
    assert len(truth_from_judges(judgements, floor=0.3)) == 1
    assert len(truth_from_judges(judgements, floor=0.2)) == 2


def test_judgements_nearer_than_two_bandwidths_make_one_cut():
    near = [[2.0], [2.3], [2.0], [2.3]]
    assert len(truth_from_judges(near, bandwidth=0.25)) == 1
    assert len(truth_from_judges(near, bandwidth=0.05)) == 2


def test_the_cuts_behind_many_noisy_judges_are_found():
    rng = np.random.default_rng(3)
    true = np.array([3.0, 5.5, 7.0, 12.0, 30.0])
    judges = []
    for _ in range(12):
        seen = true[rng.random(5) < 0.8]  # nobody sees everything
        judges.append(np.sort(np.r_[seen + rng.normal(0, 0.12, len(seen)), rng.uniform(14, 28)]))
    cuts = truth_from_judges(judges)
    assert [cut.middle for cut in cuts] == pytest.approx(true, abs=0.12)


def test_no_judges_and_judges_without_cuts_give_no_truth():
    assert truth_from_judges([]) == truth_from_judges([[], []]) == []
