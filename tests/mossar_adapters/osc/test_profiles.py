import socket
import struct
import time

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.joint_sets import COCO_17, KINECT_25
from mossar_adapters.osc.encode import bundle, encode
from mossar_adapters.osc.source import OscSource
from mossar_adapters.source import Departure

JOINTS = ("head", "neck", "torso", "l_shoulder", "l_elbow", "l_hand", "r_shoulder", "r_elbow", "r_hand")


class Wire:
    """Sends datagrams to a source."""

    def __init__(self, source):
        self.place = ("127.0.0.1", source.port)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def __call__(self, address, tags, *arguments):
        self.raw(encode(address, tags, *arguments))

    def raw(self, data):
        self.socket.sendto(data, self.place)


@pytest.fixture
def open_wire():
    opened = []

    def start(query="", **options):
        source = OscSource(parse_url(f"osc://127.0.0.1:0{query}"), ReadOptions(**options))
        wire = Wire(source)
        opened.append((source, wire))
        return source, wire

    yield start
    for source, wire in opened:
        source.close()
        wire.socket.close()


def upright(joint, frame):
    return (0.5 + 0.01 * joint, 0.1 + 0.1 * joint, 2.0 + 0.001 * frame)


def test_osceleton_joints_become_frames_of_each_user(open_wire, hear):
    source, wire = open_wire(fps=30.0)

    def send():
        for frame in range(10):
            for user in (1, 2):
                for i, name in enumerate(JOINTS):
                    wire("/joint", "sifff", name, user, *upright(i, frame))

    heard = hear(source, send)
    assert heard.performers() == ["p1", "p2"]
    for performer in ("p1", "p2"):
        assert heard.count(performer) == 10
        assert np.isfinite(heard.positions(performer)).all()
        assert heard.times(performer) == pytest.approx(np.arange(10) / 30)
    skeleton = heard.metas[0].skeleton
    assert skeleton.names == JOINTS
    assert skeleton.names[skeleton.root] == "torso"
    assert source.counters.malformed == 0


def test_unit_less_coordinates_are_scaled_to_a_usual_height(open_wire, hear):
    source, wire = open_wire()

    def send():
        for frame in range(3):
            for i, name in enumerate(JOINTS):
                wire(f"/joint/{name}/7", "fff", *upright(i, frame))

    heard = hear(source, send)
    extent = np.ptp(heard.positions("p7")[0], axis=0).max()
    assert extent == pytest.approx(1.7, rel=1e-3)
    assert "1.7 m" in heard.metas[0].unit


def test_ids_and_coordinates_may_be_integers_floats_or_doubles(open_wire, hear):
    source, wire = open_wire("?unit=m", unit="m")

    def send():
        for _ in range(3):
            wire("/joint", "sfidh", "torso", 4.0, 1, 2.5, 3)
            wire("/joint", "sifff", "head", 4, 1.0, 3.5, 3.0)

    heard = hear(source, send)
    assert heard.count("p4") == 3
    assert heard.positions("p4")[0, 0] == pytest.approx(np.array([1, 2.5, 3]) * (2.56, 1.92, 1.28))


def test_users_who_leave_and_control_messages_are_passed_on(hear):
    class Listener:
        def __init__(self):
            self.heard = []

        def control(self, address, arguments):
            self.heard.append((address, list(arguments)))

    listener = Listener()
    source = OscSource(parse_url("osc://127.0.0.1:0"), ReadOptions(), listener)
    wire = Wire(source)

    def send():
        wire("/new_user", "i", 3)
        for frame in range(3):
            for i, name in enumerate(JOINTS):
                wire("/joint", "sifff", name, 3, *upright(i, frame))
        wire("/lost_user", "i", 3)
        wire("/mossar/set/level", "s", "cluster")
        wire("/mossar/reset", "")

    heard = hear(source, send)
    wire.socket.close()
    assert heard.count("p3") == 3
    assert heard.items[-1] == Departure("p3", "lost user"), "behind the last frame"
    assert listener.heard == [("/mossar/set/level", ["cluster"]), ("/mossar/reset", [])]


def test_kinect_bodies_carry_tracking_states_as_confidence(open_wire, hear):
    source, wire = open_wire()

    def send():
        for frame in range(4):
            for i, name in enumerate(KINECT_25.names):
                state = ("Tracked", "Inferred", "NotTracked")[i % 3]
                xyz = (0.1 * i, 1.0, 2.0 + frame)
                wire(f"/bodies/72057594037944738/joints/{name}", "fffs", *xyz, state)
            wire("/bodies/72057594037944738/hands/Left", "ss", "Open", "High")

    heard = hear(source, send)
    performer = "p72057594037944738"
    assert heard.count(performer) == 4
    assert heard.metas[0].skeleton == KINECT_25
    confidence = np.concatenate([f.confidence for f in heard.frames(performer)])
    assert confidence[0, :3].tolist() == [1.0, 0.5, 0.0]
    assert heard.positions(performer)[3, 2] == pytest.approx([0.2, 1.0, 5.0])
    assert source.counters.malformed == 0


def test_nimate_joints_and_omni_messages_are_read(open_wire, hear):
    source, wire = open_wire("?unit=mm", unit="mm")

    def send():
        for frame in range(3):
            for i, name in enumerate(("head", "neck", "torso", "left_hand")):
                wire(f"/skeleton_{name}", "fffffff", 0.0, 1000.0 + 100 * i, frame, 1.0, 0.0, 0.0, 0.0)

    heard = hear(source, send)
    assert heard.metas[0].skeleton.names == ("head", "neck", "torso", "left_hand")
    assert heard.positions()[1, 3] == pytest.approx([0, 1.3, 0.001])

    source, wire = open_wire("?profile=nimate", unit="m")
    heard = hear(source, lambda: [wire("/skeleton", "f" * 45, *range(45)) for _ in range(3)])
    assert heard.positions().shape == (3, 15, 3)
    assert heard.positions()[0, 14].tolist() == [42, 43, 44]


@pytest.mark.parametrize(
    ("numbers", "people"),
    [
        ([float(i) for i in range(51)], 1),
        ([17] + [float(i) for i in range(51)], 1),
        ([1] + [float(i) for i in range(51)], 1),
        ([2] + [float(i) for i in range(102)], 2),
    ],
)
def test_flat_arrays_may_begin_with_a_count(open_wire, hear, numbers, people):
    source, wire = open_wire("?profile=flat&stride=3&joints=coco17", unit="m")
    tags = "".join("i" if isinstance(n, int) else "f" for n in numbers)
    heard = hear(source, lambda: [wire("/pose", tags, *numbers) for _ in range(3)])
    assert heard.performers() == ["p1", "p2"][:people]
    assert heard.metas[0].skeleton == COCO_17
    assert heard.positions()[0, 1].tolist() == [3, 4, 5]


def test_flat_arrays_of_four_carry_confidence_and_a_zero_says_nobody(open_wire, hear):
    source, wire = open_wire()
    pose = [value for i in range(33) for value in (0.01 * i, 0.05 * i, 0.0, 0.9)]

    def send():
        for _ in range(3):
            wire("/pose", "f" * 132, *pose)
        wire("/pose", "i", 0)

    heard = hear(source, send)
    assert heard.count() == 3
    assert heard.frames()[0].confidence[0] == pytest.approx([0.9] * 33)
    assert source.counters.malformed == source.counters.ignored == 0


def test_generic_patterns_take_joint_and_performer_from_the_address(open_wire, hear):
    query = "?profile=generic&pattern=/pose/{performer}/{joint}&args=xyzc"
    source, wire = open_wire(query, unit="cm", fps=50.0)

    def send():
        for frame in range(4):
            for name in ("hips", "head"):
                wire(f"/pose/ada/{name}", "ffff", 100.0, 170.0, frame, 0.5)

    heard = hear(source, send)
    assert heard.performers() == ["ada"]
    assert heard.positions("ada")[2, 0] == pytest.approx([1.0, 1.7, 0.02])
    assert heard.times("ada") == pytest.approx([0, 0.02, 0.04, 0.06])


def test_our_own_profile_keeps_time_order_and_names(open_wire, hear):
    source, wire = open_wire()
    positions = np.arange(2 * 3 * 20, dtype=np.float32).reshape(20, 2, 3)

    def send():
        wire("/mossar/meta", "sss", "ada", "hips", "head")
        for frame in range(20):
            if frame != 7:
                blob = positions[frame].astype(">f4").tobytes()
                wire("/mossar/frame", "sidb", "ada", frame, frame / 60, blob)

    heard = hear(source, send)
    assert heard.metas[0].skeleton.names == ("hips", "head")
    assert np.array_equal(heard.positions("ada"), np.delete(positions, 7, axis=0))
    assert np.array_equal(heard.times("ada"), np.delete(np.arange(20), 7) / 60)
    assert source.counters.gaps == 1


def test_the_user_can_name_the_performer(open_wire, hear):
    source, wire = open_wire("?performer=Ada")
    heard = hear(
        source,
        lambda: [
            wire("/mossar/frame", "sidb", "p1", i, i / 60, struct.pack(">3f", 1, 2, 3)) for i in range(3)
        ],
    )
    assert heard.performers() == ["Ada"]


def test_rubbish_is_counted_and_the_stream_goes_on(open_wire, hear):
    source, wire = open_wire(fps=30.0)
    random = np.random.default_rng(1)
    good = encode("/joint", "sifff", "head", 2, 0.5, 0.5, 0.5)
    nested = good
    for _ in range(20):
        nested = bundle([nested])
    rubbish = [
        b"",
        b"\0" * 100,
        b"#bundle\0",
        b"#bundle\0" + b"\xff" * 60_000,
        bundle([good, good])[:-3],
        bundle([good]) + struct.pack(">i", -4),
        nested,
        good[:-4],
        b"/joint\0\0,sqfff\0\0" + b"\0" * 40,
        b"/joint\0\0,s[[[[ff" + b"\0" * 16,
        b"/" + b"a" * 65_000,
        encode("/joint", "sifs", "head", 1, 0.5, "text"),
        encode("/joint", "isfff", 1, "head", 0.5, 0.5, 0.5),
        encode("/VMC/Ext/Bone/Pos", "sfffffff", "Hips", 0, 0, 0, 0, 0, 0, 0),
        encode("/VMC/Ext/T", "s", "now"),
        encode("/bodies/1/joints/Head", "fffs", 0, 0, 0, "Sleeping"),
        encode("/mossar/frame", "sidb", "p1", 0, 0.0, b"12345"),
        encode("/mossar/frame", "sidb", "p1", 0, 0.0, b"1" * 24)[:-12],
        encode("/mossar/frame", "sid", "p1", 0, 0.0).replace(b",sid", b",sidb\0\0\0") + b"\xff" * 4,
        encode("/mossar/meta", "sss", "p1", "a", "a"),
        *(random.bytes(int(n)) for n in random.integers(1, 2000, 200)),
        *(b"#bundle\0" + random.bytes(int(n)) for n in random.integers(8, 2000, 200)),
    ]

    def send():
        for frame in range(5):
            for i, name in enumerate(JOINTS):
                wire("/joint", "sifff", name, 1, *upright(i, frame))
            for data in rubbish[frame::5]:
                wire.raw(data)

    heard = hear(source, send)
    assert heard.count("p1") == 5
    assert source.counters.malformed >= len(rubbish) - 12
    assert source.counters.last_error


def test_nan_and_infinity_are_missing_joints(open_wire, hear):
    source, wire = open_wire(unit="m")

    def send():
        for _ in range(3):
            for name, x in (("head", float("nan")), ("neck", 1.0), ("torso", 1.0)):
                wire("/joint", "sifff", name, 1, x, 1.0, 1.0)

    heard = hear(source, send)
    assert np.isnan(heard.positions()[:, 0]).all()
    assert np.isfinite(heard.positions()[:, 1:]).all()


def test_only_welcome_senders_are_heard(open_wire, hear):
    source, wire = open_wire("?allow=10.0.0.0/8,192.168.1.7")
    heard = hear(source, lambda: wire("/joint", "sifff", "head", 1, 0.5, 0.5, 0.5))
    assert heard.items == []
    assert source.counters.ignored == 1


def test_a_profile_that_does_not_fit_is_explained_by_the_one_that_does(open_wire, hear):
    source, wire = open_wire("?profile=osceleton")
    hear(source, lambda: wire("/VMC/Ext/Bone/Pos", "sfffffff", "Hips", *[0.0] * 7))
    assert source.explain().endswith("1 ignored: try profile=vmc, or leave profile= out")


def test_silence_is_explained(open_wire, hear):
    source, wire = open_wire()
    assert f"127.0.0.1:{source.port}; no datagram came yet" in source.explain()
    assert f"osc://0.0.0.0:{source.port}" in source.explain()
    hear(source, lambda: [wire("/wek/outputs", "f", 0.5) for _ in range(3)])
    assert "3 datagrams came from 127.0.0.1; addresses: /wek/outputs (no profile)" in source.explain()
    assert "profile=generic" in source.explain()


def test_the_other_profile_is_named_when_the_wrong_one_was_chosen(open_wire, hear):
    source, wire = open_wire("?profile=vmc")
    heard = hear(source, lambda: wire("/joint", "sifff", "head", 1, 0.5, 0.5, 0.5))
    assert heard.items == []
    assert "/joint (fits osceleton)" in source.explain()


def test_the_kernels_drops_are_counted(open_wire, hear):
    source, wire = open_wire()
    data = encode("/joint", "sifff", "head", 1, 0.5, 0.5, 0.5)
    for _ in range(60_000):
        wire.raw(data)

    def send():
        time.sleep(1.0)  # the kernel tells with the next datagram that gets through
        wire.raw(data)

    hear(source, send)
    counters = source.counters
    assert counters.kernel_drops > 0
    assert counters.received + counters.kernel_drops == 60_001
