"""The store: the examples of all moves, described for one stream's joints, and its layout.

Only this file states the places of the parts of a store and of a performer's memory; Python asks for them.
"""

cdef extern from "simd.h" nogil:
    enum:
        FACTORS

# Address of a block that does not exist, to compute distances between the places of its parts.
cdef uint8_t* NOWHERE = <uint8_t*>4096
cdef enum:
    ROWS = DIRECTIONS + 3  # of an example in `MoveBank.rows`: directions, box, shares, stance

cdef struct MoveStore:  # The head of a store; its arrays follow.
    int64_t joints  # K
    int64_t examples  # T
    int64_t numbers  # D, of a pose: three for each joint, padded with zeros
    int64_t moves  # M
    double bar  # no stretch whose cost is above this can be recognised as any move
    int64_t girdles[4]  # of the joints, see `facing_of`; -1: moves are recognised as they were shown
    int64_t explains  # whether the nearest move in a movement is reported, too; it is in `nearest`


cdef struct MoveExample:
    int64_t move  # that it is an example of
    float size  # m, diagonal of its box
    float cost  # of the best stretch of this comparison; scratch
    float near  # the same of all stretches, where movements are explained
    float near_posture  # factor of `near` that is due to another posture
    int64_t near_first  # pose where that stretch begins


cdef struct MoveRule:
    double most  # natural logarithm of the largest cost, see `MOST`
    double again  # s after it was confirmed during which it is not confirmed again


cdef struct MoveBank:  # The parts of a store.
    MoveStore* head
    JointPair* joints  # (K,) the centre first
    int64_t* limbs  # (K,) index into the keys of `limbs.limbs_of`, -1 for none
    MoveExample* examples  # (T,)
    MoveRule* rules  # (M,)
    FloatRows rows  # (T * ROWS, D)
    float* begin  # (D,) m, first pose of the first example: the place of a joint that was never seen
    Description scratch
    uint8_t* end


cdef inline int64_t padded_to_factors(int64_t count) noexcept nogil:
    """Return the length of a line with the zeros that `line_product` needs behind it."""
    return (count + FACTORS - 1) // FACTORS * FACTORS


cdef inline MoveBank open_move_store(uint8_t* store) noexcept nogil:
    """Return the parts of a store."""
    return lay_out_move_store(store, <MoveStore*>store)


cdef MoveBank lay_out_move_store(uint8_t* store, MoveStore* head) noexcept nogil:
    """Return the parts of a store with this head, without reading it."""
    cdef MoveBank bank
    cdef int64_t line
    bank.head = head
    line = head.numbers
    bank.joints = <JointPair*>(store + sizeof(MoveStore))
    bank.limbs = <int64_t*>(bank.joints + head.joints)
    bank.examples = <MoveExample*>(bank.limbs + head.joints)
    bank.rules = <MoveRule*>(bank.examples + head.examples)
    bank.rows = floats_in_rows(<float*>(bank.rules + head.moves), head.examples * ROWS, line)
    bank.begin = bank.rows.at + bank.rows.rows * line
    bank.scratch.points = floats_in_rows(bank.begin + line, POINTS, line)
    bank.scratch.directions = floats_in_rows(bank.scratch.points.at + POINTS * line, DIRECTIONS, line)
    bank.scratch.shares = floats(bank.scratch.directions.at + DIRECTIONS * line, line)
    bank.scratch.stance = floats(bank.scratch.shares.at + line, line)
    bank.scratch.box = floats(bank.scratch.stance.at + line, line)
    bank.scratch.low = floats(bank.scratch.box.at + line, line)
    bank.scratch.size = bank.scratch.low.at + line
    bank.scratch.row = floats_in_rows(bank.scratch.size + 1, 2, DIRECTIONS + 1)
    bank.end = <uint8_t*>(bank.scratch.row.at + 2 * (DIRECTIONS + 1))
    return bank


cdef inline float* row_of_example(MoveBank* bank, int64_t t, int64_t row) noexcept nogil:
    """Return a row of example t: 0 for its directions, then box, shares, stance."""
    return bank.rows.at + (t * ROWS + row) * bank.rows.columns


cdef inline FloatRows directions_of_example(MoveBank* bank, int64_t t) noexcept nogil:
    return floats_in_rows(row_of_example(bank, t, 0), DIRECTIONS, bank.rows.columns)
