import re

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.hints import Hints
from mossar_adapters.osc.profiles.profile import Message
from mossar_adapters.osc.source import OscSource
from mossar_stream import Frames

JOINTS = ("Head", "Neck", "Torso", "LeftHand", "RightHand")
COUNT = 12


def place(i, k):
    return 0.1 * i, 1.7 - 0.3 * i, 2.0 + 0.01 * k


# Messages of frame k, and the options that read them.
FORMS = {
    "address": (
        lambda k: [(f"/{joint}", "fff", *place(i, k)) for i, joint in enumerate(JOINTS)],
        "pattern=/{joint}&args=xyz",
    ),
    "prefix": (
        lambda k: [(f"/a/skel_{joint}", "fff", *place(i, k)) for i, joint in enumerate(JOINTS)],
        "pattern=/a/skel_{joint}&args=xyz",
    ),
    "people": (
        lambda k: [
            (f"/pose/{who}/{joint}", "ffff", *place(i, k), 0.9)
            for who in ("ann", "bob")
            for i, joint in enumerate(JOINTS)
        ],
        "pattern=/pose/{performer}/{joint}&args=xyzc",
    ),
    "osceleton2": (
        lambda k: [
            (
                "/osceleton2/joint",
                "siiffffd",
                joint,
                0,
                1,
                *(100 * v for v in place(i, -k)),
                1.0,
                1.6e9 + k / 30,
            )
            for i, joint in enumerate(JOINTS)
        ],
        "pattern=/osceleton2/joint&args=j_pxyzc",
    ),
    "words": (
        lambda k: [("/joints", "ssffff", "ann", j, *place(i, k), 0.5) for i, j in enumerate(JOINTS)],
        "pattern=/joints&args=pjxyzc",
    ),
    "number_first": (
        lambda k: [(f"/t/{joint}", "ifff", k, *place(i, k)) for i, joint in enumerate(JOINTS)],
        "pattern=/t/{joint}&args=_xyz",
    ),
    "orientation_behind": (
        lambda k: [
            (f"/t/{joint}", "fffffff", *place(i, k), 0.0, 0.0, 0.0, 1.0) for i, joint in enumerate(JOINTS)
        ],
        "pattern=/t/{joint}&args=xyz",
    ),
    "orientation_first": (
        lambda k: [
            ("/t", "sfffffff", joint, 0.0, 0.6, 0.0, 0.8, *place(i, k)) for i, joint in enumerate(JOINTS)
        ],
        "pattern=/t&args=j____xyz",
    ),
    "time_first": (
        lambda k: [
            (f"/t/{joint}", "dfff", 5 + k / 30, *place(i, k)[:2], 0.1 * i - 0.01 * k)
            for i, joint in enumerate(JOINTS)
        ],
        "pattern=/t/{joint}&args=_xyz",
    ),
    "numbered_joints": (
        lambda k: [("/t", "iifff", 1, i, *place(i, k)) for i in range(len(JOINTS))],
        "pattern=/t&args=pjxyz",
    ),
    "flat": (
        lambda k: [("/all", "f" * 15, *(v for i in range(5) for v in place(i, k)))],
        "profile=flat&stride=3",
    ),
}


def heard(url, frames):
    decoder, items = OscDecoder(parse_url(url)), []
    for k in range(COUNT):
        for address, tags, *arguments in frames(k):
            items += decoder.receive(Datagram(encode(address, tags, *arguments), "127.0.0.1", 9000, k / 30))
        items += decoder.receive(Datagram(encode("/sync", "f", 1.0), "127.0.0.1", 9000, k / 30))
        items += decoder.idle(k / 30 + 0.02)
    return items + decoder.idle(60.0) + decoder.end(), decoder


@pytest.mark.parametrize("name", FORMS)
def test_the_options_are_built_from_the_messages_and_work_when_typed(name):
    frames, options = FORMS[name]
    items, decoder = heard("osc://127.0.0.1:0", frames)
    assert not [item for item in items if isinstance(item, Frames)]
    assert decoder.hints.options().endswith(options)
    items, _ = heard(f"osc://127.0.0.1:0?{decoder.hints.options()}", frames)
    found = [item for item in items if isinstance(item, Frames)]
    people = {item.performer for item in found}
    assert people == ({"ann", "bob"} if name == "people" else {"ann"} if name == "words" else {"p1"})
    for who in people:
        positions = np.concatenate([item.positions for item in found if item.performer == who])
        assert positions.shape == (COUNT, len(JOINTS), 3)
        assert np.isfinite(positions).all()
        heights = np.ptp(positions[:, :, 1], axis=1)
        assert heights == pytest.approx(1.2, abs=0.6), "in metres"


@pytest.mark.parametrize(
    "messages",
    [
        [("/wek/outputs", (0.5,))] * 5,
        [("/a", (1.0, 2.0, 3.0))] * 5,
        [("/a", ("x", "y", "z"))] * 5,
        [("/a", ("x", 1, 2.0, 3.0, b"1", None, True))] * 5,
        [("/a", ())],
        [],
    ],
)
def test_messages_without_joints_give_no_options(messages):
    hints = Hints()
    for address, arguments in messages:
        hints.add(Message(address, arguments, "", 0.0))
    assert hints.options() is None


def test_the_explanation_has_a_url_to_type(hear):
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    frames, _ = FORMS["address"]

    def send():
        import socket

        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for address, tags, *arguments in frames(0) * 3:
                sender.sendto(encode(address, tags, *arguments), ("127.0.0.1", source.port))

    hear(source, send)
    (url,) = re.findall(r'try "(\S+)"', source.explain())
    assert url == f"osc://127.0.0.1:{source.port}?profile=generic&pattern=/{{joint}}&args=xyz"


def test_a_flood_of_addresses_takes_no_memory():
    hints = Hints()
    for k in range(5000):
        hints.add(Message(f"/{k}" + "x" * (k % 400), (1.0,) * 500, "", 0.0))
    assert len(hints._seen) <= 512
    assert max(len(seen.arguments) for seen in hints._seen) <= 16
    hints.options()
