import pytest

from mossar_adapters.pipeline.emission import Emission
from mossar_stream import SettingsError, StreamEvent


def test_nothing_asked_for_lets_everything_through():
    event = StreamEvent(performer="p1", event="started", take=0)
    assert Emission().of([event]) == [event]


@pytest.mark.parametrize(
    ("word", "allowed"),
    [
        ("stream", {("stream", "")}),
        ("confirmed", {("key_frame", "confirmed"), ("move", "confirmed")}),
        ("final", {("key_frame", "final"), ("segment", "final"), ("move", "final")}),
        ("segment.final", {("segment", "final")}),
    ],
)
def test_a_word_names_a_type_or_a_status_or_both(word, allowed):
    assert Emission((word,)).allowed == allowed


@pytest.mark.parametrize("word", ["keyframe", "key_frame.closed", "stream.started"])
def test_an_unknown_word_is_refused_with_the_known_ones(word):
    with pytest.raises(
        SettingsError, match=r"key_frame, segment, activity, move, .*repetition, phase, step, stream, stats"
    ):
        Emission((word,))
