"""Abilities of sources and sinks are found by their members, also behind a wrapper, and None is not offered."""

from mossar_adapters.abilities import Counts, HasPosition, Previews, Prompt, Resumes, SkipsWaiting, offered
from mossar_adapters.demo import DemoSource
from mossar_adapters.live import Counters
from mossar_adapters.people import PeopleSource
from mossar_adapters.urls import open_sink


class Camera:
    name, live = "camera", True

    def __init__(self):
        self.counters = Counters(malformed=2)
        self.preview = None

    def skip_waiting(self):
        self.skipped = True


def test_an_ability_is_offered_by_having_its_member():
    camera = Camera()
    assert offered(camera, Counts).counters.malformed == 2
    assert offered(camera, Resumes) is None
    assert offered(DemoSource(), SkipsWaiting) is None


def test_a_member_that_is_none_is_not_offered():
    assert offered(Camera(), Previews) is None


def test_a_wrapper_offers_what_it_wraps():
    camera = Camera()
    offered(PeopleSource(camera, 1), SkipsWaiting).skip_waiting()
    assert camera.skipped


def test_sinks_say_whether_they_block():
    sink = open_sink("osc://127.0.0.1:9")
    assert offered(sink, Prompt).prompt
    assert offered(sink, HasPosition) is None
    sink.close()
