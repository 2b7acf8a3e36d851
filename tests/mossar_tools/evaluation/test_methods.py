import pytest

from mossar_stream import Settings
from mossar_tools.evaluation.chance import blind, merged, nested, randomly
from mossar_tools.evaluation.detection import FIXED, Detection, Method
from mossar_tools.evaluation.mossar import split, stream, whole
from mossar_tools.evaluation.performer import demo_takes
from mossar_tools.evaluation.trial import trial


@pytest.fixture(scope="module")
def take():
    return next(demo_takes("demo:?fps=30&seconds=12", seeds=1))


def test_confirmed_key_frames_are_those_of_splitting_with_the_running_range(take):
    settings = Settings(level="motion")
    found = stream(take, settings, "confirmed")
    assert found.times
    assert all(late >= time for time, late in zip(found.times, found.decided, strict=True))


def test_final_key_frames_are_no_more_than_confirmed_ones(take):
    settings = Settings()
    assert 0 < len(stream(take, settings, "final").times) <= len(stream(take, settings, "confirmed").times)


def test_splitting_alone_is_the_whole_hierarchy(take):
    assert len(split(take, Settings()).times) == len(whole(take, Settings()).hierarchy)


def test_blind_cuts_come_every_k_seconds(take):
    assert blind(take)["2.5 s"].times == pytest.approx([2.5, 5.0, 7.5, 10.0])


def test_random_cuts_are_as_many_as_the_true_ones_and_the_same_each_time(take):
    assert {len(found.times) for found in randomly(take).values()} == {len(take.cuts)}
    assert randomly(take) == randomly(take)


def test_nested_sets_reach_from_all_to_none():
    sets = nested([1.0, 2.0, 3.0], [2.0, 3.0, 1.0])
    assert [found.times for found in sets.values()] == [[1.0, 2.0, 3.0], [1.0, 3.0], [1.0], []]


def test_random_merging_is_the_same_each_time(take):
    assert list(merged(take, Settings()).items())[:99] == list(merged(take, Settings()).items())[:99]


def test_the_best_variant_is_chosen_for_all_takes_or_for_each(take):
    other = next(demo_takes("demo:?fps=30&seconds=12", seeds=1))

    def run(own):
        first = [cut.middle for cut in own.cuts]
        return {"a": Detection(first if own is take else []), "b": Detection(first[:-1])}

    rows = trial([take, other], [Method("made", ("best for all", "best each"), run)])
    assert [[outcome.variant for outcome in row.outcomes] for row in rows] == [["b", "b"], ["a", "b"]]
    assert rows[1].mean.f1 > rows[0].mean.f1


def test_a_method_without_a_choice_has_one_variant(take):
    (row,) = trial([take], [Method("made", FIXED, lambda _: {"": Detection([1.0])})])
    assert row.outcomes[0].found.times == [1.0]
