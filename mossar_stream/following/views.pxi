"""Views: the bytes of a bank and of a performer as numbers and records, for kernels."""

cdef struct FollowBank:  # What is followed, described for a stream.
    BankHeadSpan head  # (1,) BANK_HEAD
    BonePointSpan points  # (K,) BONE_POINT
    BoneSpan bones  # (B,) BONE
    FollowedExampleSpan examples  # (T,) FOLLOWED
    Floats rows  # the first pose, the directions of all examples, weights of bones


cdef struct FollowMemory:  # What is known of a performer, besides the cells of examples.
    FollowingStateSpan state  # (1,) FOLLOWING_STATE
    FollowedMoveSpan moves  # (M,) MOVE
    Ints happened  # (M,) at the frame that the kernel stopped at
    DoubleRows reports  # (M, REPORT and limbs)
    FloatPlanes poses  # (2, K, 3) m, of the last two frames
    Floats absences  # (K,) s, for which each point has been missing
    FloatRows directions  # (B, 3), of the sample
    Floats distances  # (n,) scratch: of the sample from each phase
    Floats products  # (n,) scratch: the same, how far it lies in the phase's direction
    FloatRows strays  # (M, B), mean square of chords; `UNJUDGED` of hidden bones
    FloatBlocks boxes  # (M, 2, B, 3), least and largest directions of the last performance
    FloatBlocks rings  # (R, ring, B, 3), directions of the last samples
    FloatRows means  # (B, 3) scratch: mean difference of directions along a way
    Int32Rows way  # (2, 2·ring) scratch: samples and phases that a way brings together
    BytePlanes hidden  # (R, ring, B), whether each bone was hidden in the last samples


cdef struct Cells:  # Where ways of aligning the stream with one example stand: one that ends in each phase, and layer.
    Int32Rows firsts  # (LAYERS, n) sample where the way began
    FloatRows costs  # (LAYERS, n) summed over phases; inf where there is no way
    FloatRows weights  # (LAYERS, n) of what was summed
    FloatRows gains  # (LAYERS, n) summed over phases
    ByteRows steps  # (ring, n) how ways have come on, at each sample


# NOT COMPILED IN ANY RUN: open_bank
# def open_bank(store):
#     """Return the bank that a store holds."""
#     head = part(store, 0, BANK_HEAD, (1,))
#     points, bones, examples = head[0].points, head[0].bones, head[0].examples
#     at_bones = BANK_HEAD_BYTES + points * BONE_POINT_BYTES
#     at_examples = at_bones + bones * BONE_BYTES
#     at_rows = at_examples + examples * FOLLOWED_BYTES
#     return Bank(
#         head,
#         part(store, BANK_HEAD_BYTES, BONE_POINT, (points,)),
#         part(store, at_bones, BONE, (bones,)),
#         part(store, at_examples, FOLLOWED, (examples,)),
#         part(store, at_rows, np.float32, ((store.size - at_rows) // 4,)),
#     )


# NOT COMPILED IN ANY RUN: open_memory
# def open_memory(memory, head):
#     """Return what is known of a performer."""
#     points, bones, moves, ring, strides = head.points, head.bones, head.moves, head.ring, head.strides
#     numbers = len(REPORT) + head.limbs
#     at_happened = FOLLOWING_STATE_BYTES + moves * MOVE_BYTES
#     at_reports = at_happened + 8 * moves
#     at_poses = at_reports + 8 * moves * numbers
#     at_absences = at_poses + 4 * 6 * points
#     at_directions = at_absences + 4 * points
#     at_distances = at_directions + 4 * 3 * bones
#     at_products = at_distances + 4 * head.phases
#     at_strays = at_products + 4 * head.phases
#     at_boxes = at_strays + 4 * moves * bones
#     at_rings = at_boxes + 4 * moves * 6 * bones
#     at_means = at_rings + 4 * strides * ring * 3 * bones
#     at_way = at_means + 4 * 3 * bones
#     at_hidden = at_way + 4 * 4 * ring
#     return Memory(
#         part(memory, 0, FOLLOWING_STATE, (1,)),
#         part(memory, FOLLOWING_STATE_BYTES, MOVE, (moves,)),
#         part(memory, at_happened, np.int64, (moves,)),
#         part(memory, at_reports, np.float64, (moves, numbers)),
#         part(memory, at_poses, np.float32, (2, points, 3)),
#         part(memory, at_absences, np.float32, (points,)),
#         part(memory, at_directions, np.float32, (bones, 3)),
#         part(memory, at_distances, np.float32, (head.phases,)),
#         part(memory, at_products, np.float32, (head.phases,)),
#         part(memory, at_strays, np.float32, (moves, bones)),
#         part(memory, at_boxes, np.float32, (moves, 2, bones, 3)),
#         part(memory, at_rings, np.float32, (strides, ring, bones, 3)),
#         part(memory, at_means, np.float32, (bones, 3)),
#         part(memory, at_way, np.int32, (2, 2 * ring)),
#         part(memory, at_hidden, np.uint8, (strides, ring, bones)),
#     )


# NOT COMPILED IN ANY RUN: open_cells
# def open_cells(memory, example):
#     """Return the cells of an example."""
#     phases, begin = example.phases, example.memory
#     size = 4 * LAYERS * phases
#     return Cells(
#         part(memory, begin, np.int32, (LAYERS, phases)),
#         part(memory, begin + size, np.float32, (LAYERS, phases)),
#         part(memory, begin + 2 * size, np.float32, (LAYERS, phases)),
#         part(memory, begin + 3 * size, np.float32, (LAYERS, phases)),
#         part(memory, begin + 4 * size, np.uint8, (2 * phases + LONGER, phases)),
#     )


# NOT COMPILED IN ANY RUN: rows_of_example
# def rows_of_example(bank, example):
#     """Return the directions of an example, (B, 3, padded phases)."""
#     return part(bank.rows, 4 * example.rows, np.float32, (bank.head[0].bones, 3, example.padded))


# NOT COMPILED IN ANY RUN: first_pose
# def first_pose(bank):
#     """Return the points at the begin of the first example, relative to the centre, (K, 3) m."""
#     return part(bank.rows, 0, np.float32, (bank.points.size, 3))


# NOT COMPILED IN ANY RUN: weights_of_bones
# def weights_of_bones(bank):
#     """Return how much each bone counts in the deviation from each example, (T, B); of one example they add up to 1."""
#     examples, bones = bank.head[0].examples, bank.head[0].bones
#     return part(bank.rows, 4 * (bank.rows.size - examples * bones), np.float32, (examples, bones))


# NOT COMPILED IN ANY RUN: mean_of_example
# def mean_of_example(bank, example):
#     """Return the mean directions of an example, (B, 3)."""
#     bones = bank.head[0].bones
#     return part(bank.rows, 4 * (example.rows + 3 * bones * example.padded), np.float32, (bones, 3))
