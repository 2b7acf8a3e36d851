"""The oracle itself, beside the paper."""

import numpy as np

from checks.reference.algorithms import envelope, generate_key_frames, remerge

# The extrema of the moving period in Fig. 7; the figure is printed without numbers, so that these values are made
# up to have the same relations to Ceiling and Floor. θ = 0.1.
START = 1100
EXTREMA = {
    1107: 0.50,  # x1, no candidate yet
    1110: 0.45,  # n1, above Floor
    1123: 0.80,  # x2, no candidate yet
    1144: 0.30,  # n2, at Floor
    1156: 0.37,  # x3, below Ceiling
    1163: 0.33,  # n3, above Floor
    1176: 0.70,  # x4, at Ceiling
    1193: 0.40,  # n4, at Floor
    1202: 0.46,  # x5, below Ceiling
    1215: 0.25,  # n5, at Floor and lower
    1219: 0.30,  # x6, below Ceiling
    1228: 0.11,
    1229: 0.05,  # crosses the threshold line
    1232: 0.00,
}
TABLE_1 = [
    (1107, None, "ignore the maximum", "no candidate"),
    (1110, None, "ignore the minimum", "insignificant"),
    (1123, None, "ignore the maximum", "no candidate"),
    (1144, 1144, "promote the minimum to the candidate", "significant"),
    (1156, 1144, "ignore the maximum", "insignificant"),
    (1163, 1144, "ignore the minimum", "insignificant"),
    (1176, None, "accept the candidate", "a significant maximum found"),
    (1193, 1193, "promote the minimum to the candidate", "significant"),
    (1202, 1193, "ignore the maximum", "insignificant"),
    (1215, 1215, "replace the candidate", "lower"),
    (1219, 1215, "ignore the maximum", "insignificant"),
    (1229, None, "end of process", "cross sigThre"),
]


def fig_7():
    """Return the curve from frame 1100 to 1232."""
    return np.interp(np.arange(START, 1233), [START, *EXTREMA], [0.0, *EXTREMA.values()])


def test_table_1_decision_by_decision():
    split = generate_key_frames(fig_7(), 0.1)
    onset, *rows = split.log
    assert onset.decision == "end of process"
    found = [
        (row.t + START, None if row.candidate is None else row.candidate + START, row.decision, row.reason)
        for row in rows
    ]
    assert found == TABLE_1
    assert [(k + START, kind) for k, kind in zip(split.key_frames, split.kinds, strict=True)][1:] == [
        (1144, "minimum"),
        (1229, "offset"),
    ]


def test_the_stream_takes_the_same_decisions_on_the_curve_of_table_1(core):
    curve = np.round(fig_7() * 1024) / 1024
    events = core.segmenter_of({}, 0.1).push(core.hand_steps(curve))
    told = [
        (e.status, e.frame + START)
        for e in events
        if e.__struct_config__.tag == "key_frame" and e.status != "final"
    ]
    (onset,) = np.flatnonzero((curve[1:] > 0.1) & (curve[:-1] <= 0.1)) + 1
    assert told == [
        ("confirmed", onset + START),
        ("candidate", 1144),
        ("confirmed", 1144),
        ("candidate", 1193),
        ("withdrawn", 1193),
        ("candidate", 1215),
        ("withdrawn", 1215),
        ("confirmed", 1229),
    ]


def test_the_envelope_rises_with_the_curve_falls_with_it_and_stays_between():
    ceiling, floor = envelope(np.array([0.0, 0.5, 0.45, 0.3, 0.35, 0.05, 0.0]), 0.1)
    np.testing.assert_allclose(ceiling, [0.1, 0.5, 0.5, 0.4, 0.4, 0.15, 0.1])
    np.testing.assert_allclose(floor, [0.1, 0.4, 0.4, 0.3, 0.3, 0.1, 0.1])


def test_a_plateau_is_one_extremum_at_its_first_frame():
    split = generate_key_frames(np.array([0, 8, 4, 4, 4, 8, 8, 8, 2]) / 16, 1 / 16)
    assert [(row.t, row.decision) for row in split.log[1:]] == [
        (2, "promote the minimum to the candidate"),
        (5, "accept the candidate"),
    ]


def test_remerging_removes_the_cheapest_key_frame_first_and_never_weakens():
    costs = {(0, 2, 5): 3.0, (2, 5, 7): 1.0, (5, 7, 9): 1.0, (2, 7, 9): 0.5, (0, 2, 7): 4.0, (0, 2, 9): 2.0}
    order = remerge([2, 5, 7], 0, 9, lambda a, k, b: costs[a, k, b])
    assert order == [(5, 1.0), (7, 1.0), (2, 2.0)]
