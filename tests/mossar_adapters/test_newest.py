"""Tables that forget the oldest entry."""

from mossar_adapters.newest import Newest


def test_the_entry_set_longest_ago_makes_room():
    table = Newest(2)
    table["a"], table["b"] = 1, 2
    table["a"] = 3  # set again: the newest
    table["c"] = 4
    assert list(table.items()) == [("a", 3), ("c", 4)]
