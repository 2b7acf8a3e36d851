"""Two bodies over every wire, whose sender exchanges and cuts ids, come out as two slots."""

import time

import numpy as np
import pytest
from pythonosc.osc_message_builder import OscMessageBuilder

from mossar_adapters.address import parse_url
from mossar_adapters.demo.body import SKELETON
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.osc.frame_sink import open_osc_frame_sink
from mossar_adapters.osc.profiles.osceleton import FIELD
from mossar_adapters.people import PeopleSource
from mossar_adapters.source import Departure, Meta
from mossar_adapters.urls import open_source
from mossar_adapters.zeromq.sink import ZmqFrameSink
from mossar_stream import Frames

COUNT = 240  # frames
EARLIER = 40  # frames, after which a sender is known to keep its port
STAGE = np.float32([-2.6, 0.0, 0.0])  # m, from the stage of the fixture to the middle of a sensor's field


def kinect(ident, joint, xyz):
    return f"/bodies/{ident}/joints/{joint}", (*xyz, "Tracked")


def osceleton(ident, joint, xyz):
    return "/joint", (joint, int(ident), *(xyz / FIELD))


def osceleton_by_address(ident, joint, xyz):
    return f"/joint/{joint}/{ident}", tuple(xyz / FIELD)


def ni_mate(ident, joint, xyz):
    return f"/person{ident}/skeleton_{joint}", tuple(xyz)


WIRES = {
    "kinectv2": kinect,
    "osceleton": osceleton,
    "osceleton by address": osceleton_by_address,
    "nimate": ni_mate,
}


def changing(k, i):
    """Ids that are exchanged, and then one of them cut."""
    return ("7", "9")[k] if i < 100 else ("9", "7")[k] if i < 160 else ("9", "12")[k]


def datagram(address, arguments, arrival):
    built = OscMessageBuilder(address)
    for argument in arguments:
        built.add_arg(float(argument) if isinstance(argument, np.floating) else argument)
    return Datagram(built.build().dgram, "127.0.0.1", 5001, arrival)


def decoded(wire, ids, bodies, together):
    """Return what a decoder makes of two people, of whose datagrams so many frames come at once."""
    decoder = OscDecoder(parse_url(f"osc://127.0.0.1:0?profile={wire.partition(' ')[0]}"))
    items, sent = [], []
    for i in range(COUNT):
        for k in range(2):
            for j, joint in enumerate(SKELETON.names):
                xyz = bodies[k, i, j] + STAGE
                sent.append(datagram(*WIRES[wire](ids(k, i), joint, xyz), i / 30 + k / 100 + j * 1e-5))
        if i % together == together - 1:
            items += decoder.receive(*sent)
            sent.clear()
    items += decoder.idle(1000.0)
    assert decoder.counters.malformed == 0
    return items


def rows_of(items):
    """Return the poses of each performer."""
    rows = {}
    for item in items:
        if isinstance(item, Frames):
            rows.setdefault(item.performer, []).extend(item.positions)
    return {name: np.stack(poses) for name, poses in rows.items()}


@pytest.mark.parametrize("together", [1, 4])
@pytest.mark.parametrize("wire", WIRES)
def test_two_bodies_with_ids_that_change_come_out_whole(bodies, script, wire, together):
    items = decoded(wire, changing, bodies, together)
    straight = rows_of(decoded(wire, lambda k, _: ("7", "9")[k], bodies, together))
    slots = rows_of(PeopleSource(script(items), 2).items())
    assert set(slots) == {"p1", "p2"}
    for slot, ident in (("p1", "p7"), ("p2", "p9")):
        found, true = slots[slot], next(rows for name, rows in straight.items() if ident[1:] in name)
        assert found.shape == true.shape == (COUNT, len(SKELETON.names), 3)
        assert np.allclose(found, true, atol=1e-5)


def test_all_people_of_one_sensor_have_one_scale_however_tall_they_are(bodies):
    rows = rows_of(decoded("osceleton", lambda k, _: ("7", "9")[k], bodies, 1))
    tall = [np.median(np.ptp(rows[name][:, :, 1], axis=1)) for name in ("p7", "p9")]
    true = [np.median(np.ptp(bodies[k, :COUNT, :, 1], axis=1)) for k in range(2)]
    assert tall[0] == pytest.approx(1.7, abs=0.05)
    assert tall[1] / tall[0] == pytest.approx(true[1] / true[0], abs=0.03)
    apart = (rows["p9"] - rows["p7"]).mean(axis=(0, 1))[0]
    assert apart == pytest.approx(
        (bodies[1] - bodies[0])[:COUNT].mean(axis=(0, 1))[0] * tall[0] / true[0], abs=0.1
    )


def changed(bodies, frames, sinks):
    """Send frames of two people through sinks under ids that change, person by person."""
    for i in range(frames):
        for k, sink in enumerate(sinks):
            name = changing(k, i)
            if not i or name != changing(k, i - 1):
                sink.announce(Meta(name, SKELETON, 30.0))
            sink.send_frames(Frames(bodies[k, i : i + 1], np.array([i / 30]), performer=name))
        time.sleep(0.002)


@pytest.mark.parametrize("encoding", ["json", "msgpack"])
def test_ids_that_change_over_zeromq(hear, bodies, encoding):
    source = open_source("zmq+bind://127.0.0.1:0", people=2)
    sink = ZmqFrameSink(parse_url(source.endpoint.replace("tcp://", "zmq://") + f"?encoding={encoding}"))
    heard = hear(source, lambda: changed(bodies, COUNT, (sink, sink)))
    sink.close()
    slots = rows_of(heard.items)
    assert set(slots) == {"p1", "p2"}
    assert np.array_equal(slots["p1"], bodies[0, :COUNT])
    assert np.array_equal(slots["p2"], bodies[1, :COUNT])


def avatars(source):
    return open_osc_frame_sink(parse_url(f"osc://127.0.0.1:{source.port}?profile=vmc"))


def perform(bodies, sink, k, first, last):
    sink.send_frames(Frames(bodies[k, first:last], np.arange(first, last) / 30, performer=f"p{k + 1}"))


@pytest.mark.parametrize("people", [None, 2])
def test_two_vmc_senders_that_start_at_once_are_two_people_from_the_first_frame_on(
    hear, bodies, caplog, people
):
    source = open_source("osc://127.0.0.1:0?profile=vmc", people=people)
    places = bodies + STAGE
    sinks = [avatars(source), avatars(source)]

    def send():
        for k, sink in enumerate(sinks):
            sink.announce(Meta(f"p{k + 1}", SKELETON, 30.0))
        for i in range(90):
            for k in range(2):
                perform(places, sinks[k], k, i, i + 1)
            time.sleep(1 / 30)  # as the clocks of the senders say

    heard = hear(source, send)
    for sink in sinks:
        sink.close()
    slots = rows_of(heard.items)
    assert {name: len(poses) for name, poses in slots.items()} == {"p1": 90, "p2": 90}
    sides = sorted((poses[:, :, 0].mean(axis=1) for poses in slots.values()), key=np.median)
    assert sides[0].max() < sides[1].min()
    assert not caplog.records  # neither a clock that stands nor an id that is refused
    for name in slots:
        times = np.concatenate(
            [f.times for f in heard.items if isinstance(f, Frames) and f.performer == name]
        )
        assert np.allclose(np.diff(times), 1 / 30, atol=1e-4)


def test_a_second_vmc_sender_is_one_more_person_and_one_that_restarts_the_same(hear, bodies):
    source = open_source("osc://127.0.0.1:0?profile=vmc", people=2)
    places = bodies + STAGE
    sinks = [avatars(source), avatars(source)]

    def send():
        for k, sink in enumerate(sinks):
            sink.announce(Meta(f"p{k + 1}", SKELETON, 30.0))
        for i in range(EARLIER):  # the second one starts later
            perform(places, sinks[0], 0, i, i + 1)
            time.sleep(1 / 30)
        for i in range(120):
            for k in range(2):
                perform(places, sinks[k], k, i + EARLIER * (1 - k), i + EARLIER * (1 - k) + 1)
            time.sleep(1 / 30)  # as the clocks of the senders say
        sinks[1].close()  # its program is started again, and has another port
        sinks[1] = avatars(source)
        sinks[1].announce(Meta("p2", SKELETON, 30.0))
        for i in range(120, COUNT - EARLIER):
            for k in range(2):
                perform(places, sinks[k], k, i + EARLIER * (1 - k), i + EARLIER * (1 - k) + 1)
            time.sleep(1 / 30)  # as the clocks of the senders say

    heard = hear(source, send)
    for sink in sinks:
        sink.close()
    slots = rows_of(heard.items)
    assert set(slots) == {"p1", "p2"}
    sides = {name: poses[:, :, 0].mean(axis=1) for name, poses in slots.items()}
    left = "p1" if sides["p1"][0] < sides["p2"][0] else "p2"
    right = "p2" if left == "p1" else "p1"
    assert (len(slots[left]), len(slots[right])) == (COUNT, COUNT - EARLIER)
    assert sides[left].max() < sides[right].min()
    assert not [item for item in heard.items if isinstance(item, Departure)]


@pytest.mark.parametrize("people", [None, 2])
@pytest.mark.parametrize("ahead", [-60.0, -1.0, 0.3, 1.0, 60.0])
def test_a_second_vmc_sender_whose_clock_is_another_or_set_tears_no_take(hear, bodies, people, ahead):
    source = open_source("osc://127.0.0.1:0?profile=vmc", people=people)
    places = bodies + STAGE
    sinks = [avatars(source), avatars(source)]
    start = 100.0  # s

    def send():
        for k, sink in enumerate(sinks):
            sink.announce(Meta(f"p{k + 1}", SKELETON, 30.0))
        begun = time.monotonic()
        for i in range(120):
            time.sleep(max(0.0, begun + i / 60 - time.monotonic()))
            for k in range(2 if i >= 30 else 1):
                sent = start + i / 60 + k * (ahead if i < 80 else -90.0)
                sinks[k].send_frames(Frames(places[k, i : i + 1], np.array([sent]), performer=f"p{k + 1}"))

    heard = hear(source, send)
    for sink in sinks:
        sink.close()
    assert set(heard.performers()) == {"p1", "p2"}
    assert np.allclose(heard.times("p1"), start + np.arange(120) / 60, atol=1e-4)  # s, of VMC's float32
    assert len(heard.times("p2")) == 90
    steps = np.diff(heard.times("p2"))
    assert np.allclose(np.delete(steps, 49), 1 / 60, atol=1e-4)
    assert 0 < steps[49] < 0.2, "where the clock is set"
    assert np.abs(heard.times("p2") - heard.times("p1")[30:]).max() < 0.2
    assert not [item for item in heard.items if isinstance(item, Departure)]
