import json
import threading
import time

import numpy as np
import pytest
import zmq

from mossar_adapters.address import parse_url
from mossar_adapters.control.requests import Control
from mossar_adapters.control.zeromq import ZmqControl
from mossar_adapters.demo import DemoSource
from mossar_adapters.pipeline import Pipeline
from mossar_stream import FollowEvent, MossarError, Moves, StreamEvent


class Kept:
    name = "kept"
    dropped = 0

    def __init__(self):
        self.events = []

    def announce(self, meta):
        pass

    def send(self, events):
        self.events += events

    def close(self):
        pass


def wait_until(happened, seconds=120):
    """Wait for something that happens beside, and leave the processor to it."""
    until = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < until
        time.sleep(0.01)


@pytest.fixture
def running():
    """A pipeline that runs on two performers until the test ends, and its sink."""
    source = DemoSource(performers=2, seed=3)
    sink = Kept()
    pipeline = Pipeline([source], [sink])
    thread = threading.Thread(target=pipeline.run)
    thread.start()
    wait_until(lambda: len(pipeline.pool) == 2 and pipeline.outcome.frames)
    yield pipeline, sink
    pipeline.stop()
    thread.join()


def ask(pipeline, request):
    return json.loads(Control(pipeline).answer(json.dumps(request).encode()))


def test_the_level_of_all_performers_can_be_set(running):
    pipeline, _ = running
    answer = ask(pipeline, {"set": {"level": "cluster"}})
    assert answer == {"ok": True, "value": {"level": "cluster"}, "new_take": True}
    assert ask(pipeline, {"set": {"sig_threshold": 0.03}}) == {"ok": True, "value": {"sig_threshold": 0.03}}
    assert {pipeline.pool[name].level for name in pipeline.pool.names} == {"cluster"}
    assert ask(pipeline, {"get": "settings"})["value"]["level"] == "cluster"


def test_the_level_of_one_performer_can_be_set(running):
    pipeline, _ = running
    assert ask(pipeline, {"set": {"level": 0.7}, "performer": "p2"})["ok"]
    assert (pipeline.pool["p1"].level, pipeline.pool["p2"].level) == ("motion", 0.7)
    assert ask(pipeline, {"get": "settings", "performer": "p2"})["value"]["level"] == 0.7


def test_other_settings_can_be_changed_and_begin_a_new_take_where_they_must(running):
    pipeline, sink = running
    assert ask(pipeline, {"set": {"sig_threshold": "0.07"}})["ok"]
    assert ask(pipeline, {"set": {"window": 0.4, "refine": 0.2}, "performer": "p1"})["ok"]
    assert pipeline.pool["p1"].settings.window == 0.4
    assert (pipeline.pool["p1"].settings.sig_threshold, pipeline.pool["p2"].settings.sig_threshold) == (
        0.07,
        0.07,
    )
    assert pipeline.pool.settings.window is None
    pipeline.outlets[0].drain(1)
    ended = [
        (e.performer, e.reason) for e in sink.events if isinstance(e, StreamEvent) and e.event == "ended"
    ]
    assert ended == [("p1", "settings changed")]


def test_stats_tell_about_every_performer(running):
    value = ask(running[0], {"get": "stats"})["value"]
    assert set(value) == {"p1", "p2"}
    assert value["p1"]["frames"] > 0


def test_a_reset_ends_the_takes(running):
    pipeline, sink = running
    assert ask(pipeline, {"do": "reset"}) == {"ok": True, "value": ["p1", "p2"]}
    assert ask(pipeline, {"get": "stats"})["ok"]
    pipeline.outlets[0].drain(1)
    resets = [e.performer for e in sink.events if isinstance(e, StreamEvent) and e.event == "reset"]
    assert resets == ["p1", "p2"]


@pytest.mark.parametrize(
    ("request_", "error"),
    [
        ({}, '"set", "get" and "do"'),
        ({"get": "stats", "do": "reset"}, '"set", "get" and "do"'),
        ({"get": "nothing"}, "settings, stats, following and people"),
        ({"do": "dance"}, "there are reset, exchange, pin and unpin"),
        ({"set": {"level": "strong"}}, "posture, motion, cluster"),
        ({"set": {"nothing": 1}}, "no setting called 'nothing'"),
        ({"set": {"level": "motion"}, "performer": "p9"}, "no performer called 'p9'; there are p1, p2"),
        ({"set": 3}, "object"),
        ({"bla": 3}, "bla"),
        ([], "object"),
    ],
)
def test_a_wrong_request_gets_a_clear_answer(running, request_, error):
    answer = ask(running[0], request_)
    assert answer["ok"] is False
    assert error in answer["error"]


def test_what_is_followed_can_be_asked_and_set_while_running():
    source = DemoSource.from_url("demo:?seconds=9&moves=rest:2,squat", speed="max")
    meta, *chunks = source.items()
    shown = np.concatenate([chunk.positions for chunk in chunks])[60:300]
    moves = Moves(meta.skeleton)
    for name in ("squat", "other"):
        moves.add(name, shown, 60.0)
    sink = Kept()
    squats = ",".join(["rest:2", "squat"] * 60)
    live = DemoSource.from_url(f"demo:?moves={squats}", speed=2.0)
    pipeline = Pipeline([live], [sink], moves=moves, follow=("other",))
    thread = threading.Thread(target=pipeline.run)
    thread.start()
    try:
        wait_until(lambda: pipeline.outcome.frames)
        assert ask(pipeline, {"get": "following"})["value"]["p1"].keys() == {"other"}
        assert ask(pipeline, {"set": {"follow": "all"}}) == {"ok": True, "value": {"follow": True}}
        assert ask(pipeline, {"get": "following"})["value"]["p1"].keys() == {"squat", "other"}
        for wrong in ({"follow": ["squatt"]}, {"follow": 3}, {"follow": ["squat"], "level": "motion"}):
            answer = ask(pipeline, {"set": wrong})
            assert answer["ok"] is False
            assert "squatt" in answer["error"] or "follow" in answer["error"]
        assert ask(pipeline, {"set": {"follow": ["squat"]}})["value"] == {"follow": ["squat"]}
        states = []

        def is_done():
            state = ask(pipeline, {"get": "following"})["value"]["p1"]["squat"]
            states.extend([state] if state else [])
            return any(is_done_squat(event) for event in sink.events) and states

        wait_until(is_done)
        assert 0 < states[0]["progress"] <= 1
        assert set(states[0]) >= {"count", "tempo", "certainty", "deviation", "limbs", "joint"}
        assert ask(pipeline, {"set": {"follow": []}})["value"] == {"follow": []}
        assert ask(pipeline, {"get": "following"})["value"] == {"p1": {}}
    finally:
        pipeline.stop()
        thread.join()


def is_done_squat(event):
    return isinstance(event, FollowEvent) and (event.name, event.status) == ("squat", "done")


def test_what_is_no_json_gets_an_answer_too(running):
    control = Control(running[0])
    for message in (b"", b"\xff", b"{" * 10_000, b'"' + b"x" * 100_000 + b'"'):
        assert json.loads(control.answer(message))["ok"] is False


def test_osc_messages_are_applied(running, caplog):
    pipeline, _ = running
    control = Control(pipeline)
    control.apply("/mossar/set/level", ["cluster"])
    control.apply("/mossar/set/level", [])
    control.apply("/mossar/set/level", ["nonsense"])
    control.apply("/mossar/set/level", [float("nan")])
    control.apply("/mossar/reset", [])
    ask(pipeline, {"get": "stats"})
    assert pipeline.pool.level == "cluster"
    assert len(caplog.messages) == 3


def test_requests_come_over_zeromq(running):
    served = ZmqControl(parse_url("zmq+bind://127.0.0.1:0"), Control(running[0]).answer)
    with zmq.Context() as context, context.socket(zmq.REQ) as client:
        client.setsockopt(zmq.LINGER, 0)
        client.setsockopt(zmq.RCVTIMEO, 3000)
        client.connect(served.endpoint)
        client.send(b'{"get": "settings"}')
        assert json.loads(client.recv())["value"]["level"] == "motion"
        client.send_multipart([b"nonsense", np.zeros(3).tobytes()])
        assert json.loads(client.recv())["ok"] is False
    served.close()
    served.close()


def test_an_address_in_use_is_an_error(running):
    served = ZmqControl(parse_url("zmq+bind://127.0.0.1:0"), Control(running[0]).answer)
    port = served.endpoint.rpartition(":")[2]
    with pytest.raises(MossarError, match=port):
        ZmqControl(parse_url(f"zmq+bind://127.0.0.1:{port}"), Control(running[0]).answer)
    served.close()
