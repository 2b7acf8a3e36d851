"""Comparison: how unlike the segments on both sides of a moment are, at moments all over a recording.

This is what Li and Leung's recursion asks of the path kernel, which this package compares Mossar with.
"""


# NOT COMPILED IN ANY RUN: _fill
# def _fill(params, poses, times, starts, summaries, joints):
#     """Summarise the pieces.
# 
#     Args:
#         params: (1,) record of the measure.
#         poses: (n, 4, padded_joints) m relative to the centre.
#         times: (n,) s.
#         starts: (pieces,) first frame of each.
#         summaries: (pieces, slot), zero; set.
#         joints: J.
#     """
#     for i in range(len(summaries)):
#         end = starts[i + 1] if i + 1 < len(summaries) else len(times)
#         for frame in range(starts[i], end):
#             weight = times[frame] - times[frame - 1] if frame > 0 else 0.0
#             add_pose(params[0], summaries[i], poses[frame], joints, times[frame], weight)


# NOT COMPILED IN ANY RUN: _comparison_gather
# def _gather(params, summaries, size, later):
#     """Set `later` to the summaries of `size` pieces from each piece on, closed."""
#     for i in range(len(summaries) - size + 1):
#         for k in range(i, i + size):
#             merge_into(params[0], later[i], summaries[k])
#         close(params[0], later[i])


# NOT COMPILED IN ANY RUN: _comparison_compare
# def _compare(params, summaries, later, bounds, found):
#     """Set the strengths at pieces from the first on; `bounds` are those of `Comparison.between` and the size."""
#     first, size, longest = bounds
#     slot = summaries.shape[1]
#     earlier, closed, both = np.zeros(slot), np.zeros(slot), np.zeros(slot)
#     for i in range(len(found)):
#         if i > longest:
#             earlier[:] = 0.0
#             for k in range(first + i - longest, first + i - 1):
#                 merge_into(params[0], earlier, summaries[k])
#         if i > 0:
#             merge_into(params[0], earlier, summaries[first + i - 1])
#         if size <= i <= len(found) - 1 - size:
#             closed[:] = earlier
#             close(params[0], closed)
#             found[i] = strength(params[0], closed, later[first + i], both)
