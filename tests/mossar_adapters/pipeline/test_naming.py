from mossar_adapters.pipeline.naming import Naming


def test_the_first_source_keeps_a_name_and_the_next_one_gets_a_free_one():
    naming = Naming(["a.bvh", "b.bvh"])
    assert naming.performer(0, "p1").name == "p1"
    assert naming.performer(1, "p1").name == "p2"
    assert naming.performer(1, "ann").name == "ann"
    assert naming.performer(0, "p1") is naming.performers["p1"]
    assert naming.performers["p2"].source == 1
    assert [performer.name for performer in naming.of_source(1)] == ["p2", "ann"]


def test_positions_survive_a_snapshot():
    naming = Naming(["a.bvh", "b.bvh"])
    naming.performer(0, "p1")
    naming.performer(1, "p1").received = 5
    other = Naming(["a.bvh", "b.bvh"])
    assert other.fits(naming.positions())
    other.resume(naming.positions())
    assert other.performer(1, "p1").name == "p2"
    assert other.positions() == naming.positions()
    assert other.positions()[1].frames == {"p1": 5}
    assert not Naming(["a.bvh"]).fits(naming.positions())


def test_a_forgotten_performer_leaves_nothing_and_begins_anew():
    naming = Naming(["a.bvh", "b.bvh"])
    for source in (0, 1):
        for number in range(10):
            naming.performer(source, f"x{number}").unusable = 1
    naming.performer(0, "x0")
    naming.forget({"x3"}, 2)
    assert list(naming.performers) == ["x0", "x3", "x9", "p9", "p10"]
    assert [performer.own for performer in naming.of_source(0)] == ["x3", "x9", "x0"]
    assert [performer.own for performer in naming.of_source(1)] == ["x8", "x9"]
    assert naming.known(0, "x5") is None
    assert naming.performer(0, "x5").unusable == 0
