"""Two bodies over OSC, whose sender exchanges and cuts ids, come out as two slots."""

import numpy as np
import pytest
from pythonosc.osc_message_builder import OscMessageBuilder

from mossar_adapters.address import parse_url
from mossar_adapters.demo.body import SKELETON
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.people import PeopleSource
from mossar_stream import Frames


def kinect(ident, joint, xyz):
    return f"/bodies/{ident}/joints/{joint}", (*xyz, "Tracked")


def datagram(address, arguments, arrival):
    built = OscMessageBuilder(address)
    for argument in arguments:
        built.add_arg(float(argument) if isinstance(argument, np.floating) else argument)
    return Datagram(built.build().dgram, "127.0.0.1", 5001, arrival)


@pytest.mark.parametrize("together", [1, 4])
def test_two_bodies_with_ids_that_change_come_out_whole(bodies, script, together):
    decoder = OscDecoder(parse_url("osc://127.0.0.1:0?profile=kinectv2"))
    items, sent = [], []
    for i in range(240):
        ids = ("7", "9") if i < 100 else ("9", "7") if i < 160 else ("9", "12")
        for k in range(2):
            for j, joint in enumerate(SKELETON.names):
                sent.append(datagram(*kinect(ids[k], joint, bodies[k, i, j]), i / 30 + k / 100 + j * 1e-5))
        if i % together == together - 1:
            items += decoder.receive(*sent)
            sent.clear()
    items += decoder.idle(1000.0)
    rows = {"p1": [], "p2": []}
    for item in PeopleSource(script(items), 2).items():
        if isinstance(item, Frames):
            rows[item.performer] += list(item.positions)
    roots = [np.array([pose.mean(axis=0)[0] for pose in rows[name]]) for name in ("p1", "p2")]
    assert [len(found) for found in roots] == [240, 240]
    # The two stand 1.5 m apart: no frame of one is in the other's slot. Units and axes are the profile's.
    assert roots[0].std() < 0.4
    assert roots[1].std() < 0.4
    assert abs(roots[0].mean() - roots[1].mean()) > 1.0
