import numpy as np

from mossar_adapters.pipeline.naming import Naming
from mossar_stream import Frames


def test_the_first_source_keeps_a_name_and_the_next_one_gets_a_free_one():
    naming = Naming(["a.bvh", "b.bvh"])
    assert naming.name(0, "p1") == "p1"
    assert naming.name(1, "p1") == "p2"
    assert naming.name(1, "ann") == "ann"
    assert naming.name(0, "p1") == "p1"
    assert naming.source_of("p2") == 1
    assert naming.of_source(1) == ["p2", "ann"]


def test_positions_survive_a_snapshot():
    naming = Naming(["a.bvh", "b.bvh"])
    naming.name(0, "p1")
    naming.name(1, "p1")
    naming.count(1, Frames(np.zeros((5, 2, 3), np.float32), np.zeros(5)))
    other = Naming(["a.bvh", "b.bvh"])
    assert other.fits(naming.positions())
    other.resume(naming.positions())
    assert other.name(1, "p1") == "p2"
    assert other.positions()[1].frames == {"p1": 5}
    assert not Naming(["a.bvh"]).fits(naming.positions())
