"""Series: examples that are saved together, and one that is unlike the others."""

import numpy as np
import pytest

from mossar_stream import Moves, MovesError
from mossar_tools.series import Series
from mossar_tools.taking import Movement

from .test_teach import FPS, PERSON, PUNCH, RAISE, reach


def movement(positions):
    return Movement(positions.astype(np.float32), FPS, 0.0, len(positions) / FPS, (0, len(positions) - 1))


OTHER_PUNCH = movement(reach(1, (0.05, 0.2, 0.85), 32))
PUNCHED, RAISED = movement(PUNCH), movement(RAISE)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "moves.json"


def test_nothing_is_in_the_file_before_it_is_saved(path):
    series = Series(path, PERSON, "punch")
    shown = [series.show(PUNCHED), series.show(OTHER_PUNCH)]
    assert [(one.is_kept, one.count, one.unlike) for one in shown] == [(True, 1, ()), (True, 2, ())]
    assert not path.exists()
    series.save(path)
    assert [one.name for one in Moves.load(path).examples] == ["punch", "punch"]


def test_one_that_is_unlike_the_others_is_not_kept(path):
    series = Series(path, PERSON, "punch")
    series.show(PUNCHED)
    shown = series.show(RAISED)
    assert (shown.is_kept, shown.count, series.has_refused) == (False, 1, True)
    assert "punch: example 2" in shown.unlike[0]
    assert series.show(OTHER_PUNCH).is_kept
    assert not series.has_refused
    assert len(series.save(path)) == 2


def test_others_are_those_of_the_file_too(path):
    first = Series(path, PERSON, "punch")
    first.show(PUNCHED)
    first.save(path)
    assert not Series(path, PERSON, "punch").show(RAISED).is_kept
    assert Series(path, PERSON, "raise").show(RAISED).is_kept


def test_one_that_is_unlike_the_others_may_be_kept(path):
    series = Series(path, PERSON, "punch")
    series.show(PUNCHED)
    with pytest.raises(MovesError, match="nothing to keep"):
        series.keep()
    series.show(RAISED)
    assert (series.keep().count, series.has_refused) == (2, False)
    with pytest.raises(MovesError, match="nothing to keep"):
        series.keep()
    keeping = Series(None, PERSON, "punch", keeps=True)
    keeping.show(PUNCHED)
    shown = keeping.show(RAISED)
    assert shown.is_kept
    assert shown.unlike


def test_the_first_is_dropped_if_the_next_two_are_alike(path):
    series = Series(path, PERSON, "punch")
    series.show(RAISED)
    assert not series.show(PUNCHED).is_kept
    shown = series.show(OTHER_PUNCH)
    assert (shown.is_kept, shown.is_first_dropped, shown.count) == (True, True, 2)
    lengths = [one.seconds(len(PERSON)) for one in series.save(path).examples]
    alone = [Series(None, PERSON, "x").show(one).example.seconds(3) for one in (PUNCHED, OTHER_PUNCH)]
    assert lengths == alone


def test_an_example_of_the_file_is_never_dropped(path):
    first = Series(path, PERSON, "punch")
    first.show(RAISED)
    first.save(path)
    series = Series(path, PERSON, "punch")
    assert [series.show(one).is_kept for one in (PUNCHED, OTHER_PUNCH)] == [False, False]


def test_a_pause_is_part_of_the_example():
    there = reach(1, (0, 0.2, 0.9), 40)[:20]
    held = np.concatenate([there, np.repeat(there[-1:], 30, axis=0), there[::-1]])
    example = Series(None, PERSON, "reach").show(movement(held)).example
    assert example.seconds(len(PERSON)) == pytest.approx(len(held) / FPS, abs=0.3)


def test_other_skeletons_are_refused_at_once(path):
    first = Series(path, PERSON, "punch")
    first.show(PUNCHED)
    first.save(path)
    other = type(PERSON)(("hip", "tail"), (-1, 0))
    with pytest.raises(Exception, match="another skeleton"):
        Series(path, other, "wag")
