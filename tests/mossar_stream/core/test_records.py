"""Tests of the numpy types of structs."""

import re

import numpy as np
import pytest

from mossar_stream.core.records import record_types

DECLARED = "Point float at[3]; int32_t joint\nFoot int8_t state; Point places[4]; double times[2][3]"
SIZES = {"Foot": 120, "Point": 16}


def test_structs_become_types_with_their_names_shapes_and_gaps():
    found = record_types(DECLARED, SIZES)
    assert found["Point"] == np.dtype([("at", "f4", (3,)), ("joint", "i4")])
    foot = found["Foot"]
    assert foot.names == ("state", "places", "times")
    assert [foot.fields[name][1] for name in foot.names] == [0, 4, 72]
    assert foot["places"] == np.dtype((found["Point"], (4,)))
    assert foot["times"].shape == (2, 3)


def test_a_struct_that_the_compiler_laid_out_in_another_way_is_told():
    with pytest.raises(TypeError, match=re.escape("Foot has 112 bytes, not 120")):
        record_types(DECLARED, SIZES | {"Foot": 112})


def test_a_struct_that_is_not_declared_or_holds_another_is_told():
    with pytest.raises(KeyError, match="Curve"):
        record_types(DECLARED, {"Curve": 8})
    with pytest.raises(KeyError, match="Curve"):
        record_types("Range Curve curve", {"Range": 8})
