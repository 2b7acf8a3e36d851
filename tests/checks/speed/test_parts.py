"""What the parts that developers measure rest on."""

import numpy as np
import pytest

from checks.speed.forms import FORMS, LISTS, MORE, forms
from mossar_tools.bench.motion import performer


@pytest.fixture(scope="module")
def motion():
    return performer(4.0)


def test_forms_that_people_hand_over_are_measured_beside_ours(motion):
    rows = {row.name: row for row in forms(motion, 200, 1)}
    assert list(rows) == [f"{name}: p50" for name in (*FORMS, *LISTS)]
    assert all(0.1 < row.value < 10_000 for row in rows.values())
    assert rows["lists of lists: p50"].target is None
    own = float(rows["float64 positions: p50"].note.rpartition(" ")[2])
    assert rows["float64 positions: p50"].target.limit == pytest.approx(own + MORE, abs=0.01)
    positions, moment = FORMS["float64 and numpy scalar"](motion.positions[0], 0.5)
    assert (positions.dtype, type(moment)) == (np.float64, np.float64)
    assert not FORMS["view that is not contiguous"](motion.positions[0], 0.5)[0].flags.c_contiguous
    assert isinstance(LISTS["lists of lists"](motion.positions[0], 0.5)[0][0], list)
