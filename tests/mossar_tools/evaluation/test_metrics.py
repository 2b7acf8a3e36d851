import math

import pytest

from mossar_tools.evaluation.matching import Cut, match
from mossar_tools.evaluation.metrics import mean_scores, median, perf, score, segmentation_rate

CUTS = [Cut(2.0, 2.0, 2.0), Cut(6.0, 6.0, 6.0)]


def scores_of(found, cuts=CUTS, **options):
    return score(found, cuts, tolerance=0.25, duration=10.0, **options)


def test_precision_recall_and_f1_of_a_hand_computed_case():
    scores = scores_of([2.1, 4.0, 9.0])
    assert (scores.precision, scores.recall) == (1 / 3, 1 / 2)
    assert scores.f1 == pytest.approx(0.4)
    assert scores.key_frames == 1.5


def test_perfect_key_frames_score_1_in_everything():
    scores = scores_of([2.0, 6.0])
    assert (scores.precision, scores.recall, scores.f1, scores.atsr, scores.perf) == (1, 1, 1, 1, 1)


def test_atsr_of_a_hand_computed_case():
    # Segments 0-2, 2-6 and 6-10 s; errors 0.2 s and 0.1 s: 1 - (0.2/2 + 0.3/4 + 0.1/4) / 3
    assert scores_of([2.2, 5.9]).atsr == pytest.approx(1 - (0.1 + 0.075 + 0.025) / 3)


def test_atsr_counts_segments_with_both_ends_hit_only():
    # Only 0-2 s has both: 1 - 0.2/2
    assert scores_of([2.2]).atsr == pytest.approx(0.9)
    assert scores_of([4.0]).atsr == 0.0


def test_atsr_starts_where_the_recording_does():
    cuts = [Cut(102.0, 102.0, 102.0)]
    assert segmentation_rate(match([102.1], cuts, 0.25), cuts, 100.0, 104.0) == pytest.approx(0.95)


def test_perf_fits_the_papers_table_3():
    for expected, atsr, f1 in ((0.928, 0.785, 0.976), (0.957, 0.852, 0.991), (0.980, 0.942, 0.991)):
        assert perf(f1, atsr) == pytest.approx(expected, abs=0.003)


def test_perf_is_0_where_nothing_is_right():
    assert perf(0.0, 1.0) == perf(1.0, 0.0) == perf(0.0, 0.0) == 0.0


def test_a_recording_without_cuts_is_done_perfectly_by_finding_nothing():
    assert scores_of([], []).f1 == scores_of([], []).perf == 1.0
    assert scores_of([3.0], []).f1 == scores_of([3.0], []).precision == 0.0


def test_nothing_found_scores_0_without_an_error():
    scores = scores_of([])
    assert (scores.precision, scores.recall, scores.f1, scores.perf) == (0, 0, 0, 0)


def test_delays_count_from_the_true_cut_to_the_decision():
    assert scores_of([2.1, 4.0], decided=[5.0, 6.0]).delays == (3.0,)


def test_the_mean_is_over_recordings_and_pools_errors():
    mean = mean_scores([scores_of([2.0, 6.0]), scores_of([4.0])])
    assert mean.f1 == 0.5
    assert mean.errors == (0.0, 0.0)


def test_the_median_of_nothing_is_nan():
    assert math.isnan(median(()))
