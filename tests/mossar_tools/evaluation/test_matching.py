import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mossar_tools.evaluation.matching import Cut, match


def at(*times):
    return [Cut(time, time, time) for time in times]


def pairs(found, cuts, tolerance):
    return [(hit.cut, hit.found) for hit in match(found, cuts, tolerance)]


def test_a_key_frame_within_the_tolerance_hits_and_one_beyond_does_not():
    assert pairs([1.25, 2.26], at(1.0, 2.0), 0.25) == [(0, 0)]


def test_the_tolerance_counts_from_the_earliest_and_the_latest_frame_of_a_cut():
    assert pairs([0.75, 3.25], [Cut(1.0, 1.5, 2.0), Cut(2.0, 2.5, 3.0)], 0.25) == [(0, 0), (1, 1)]


def test_one_key_frame_hits_one_cut_only():
    assert pairs([1.05], at(1.0, 1.2), 0.25) == [(0, 0)]


def test_one_cut_is_hit_by_one_key_frame_only_by_the_nearest():
    assert pairs([0.9, 0.95, 1.2], at(1.0), 0.25) == [(0, 1)]


def test_more_hits_are_better_than_nearer_ones():
    # The second key frame is the nearest to the first cut, but then the second cut is not hit.
    assert pairs([0.8, 1.05], at(1.0, 1.2), 0.25) == [(0, 0), (1, 1)]


def test_errors_are_signed_and_from_the_middle():
    hits = match([0.9, 2.2], [Cut(0.5, 1.0, 1.5), Cut(2.0, 2.0, 2.0)], 0.25)
    assert np.allclose([hit.error for hit in hits], [-0.1, 0.2])


def test_nothing_found_and_nothing_to_find_match_nothing():
    assert match([], at(1.0), 0.25) == match([1.0], [], 0.25) == []


@given(
    st.lists(st.integers(0, 20), max_size=5, unique=True).map(sorted),
    st.lists(st.integers(0, 20), max_size=4).map(sorted),
    st.integers(0, 4),
)
def test_no_other_matching_has_more_hits_or_as_many_with_less_error(found, cuts, tolerance):
    times, truth = [float(f) for f in found], at(*map(float, cuts))
    hits = match(times, truth, float(tolerance))
    best = (0, 0.0)
    for size in range(min(len(found), len(cuts)) + 1):
        for own in itertools.combinations(range(len(cuts)), size):
            for keys in itertools.permutations(range(len(found)), size):
                errors = [abs(times[k] - cuts[c]) for c, k in zip(own, keys, strict=True)]
                if all(error <= tolerance for error in errors):
                    best = max(best, (size, -sum(errors)))
    assert (len(hits), -sum(abs(hit.error) for hit in hits)) == best
