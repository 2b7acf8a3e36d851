import sys

import pytest

from checks.flood import flooded

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")


def test_a_flood_does_no_lasting_harm():
    result = flooded(rate=30_000, seconds=2.0, phase=1.0)
    before, _, after = result.rates
    assert before == pytest.approx(60, rel=0.1)
    assert after == pytest.approx(60, rel=0.05)
    assert result.flood > 10_000
    assert result.missing == 0
    assert result.memory[1] - result.memory[0] < 5 << 20
