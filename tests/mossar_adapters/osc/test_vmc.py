import re
import socket

import msgspec
import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files import ReadOptions, open_motion
from mossar_adapters.files.kinematics import joint_positions
from mossar_adapters.joint_sets import BLAZEPOSE_33, COCO_17, KINECT_20
from mossar_adapters.osc.assembly.humanoid import mapped_bones, present_parents, rest_skeleton
from mossar_adapters.osc.assembly.known_joints import ClosedFrame
from mossar_adapters.osc.assembly.vmc_frames import VmcFrames, exact_time
from mossar_adapters.osc.assembly.vmc_pose import MIRROR, VmcPose, rotations_of
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.osc.encode import bundle, encode
from mossar_adapters.osc.frame_sink import VmcFrameSink
from mossar_adapters.osc.profiles.vmc import BONE
from mossar_adapters.osc.source import OscSource
from mossar_adapters.osc.vmc_writer import PositionBones
from mossar_adapters.source import Meta
from mossar_stream import Frames, Skeleton

HALF = 0.5**0.5
STILL = (0.0, 0.0, 0.0, 1.0)
FRAMES = 60


@pytest.fixture
def round_trip(hear):
    """Send the first frames of a BVH as VMC and return what arrives, the motion and its own positions."""

    def run(path, sink_query="", source_query="", absent=()):
        motion = open_motion(path)
        bones = mapped_bones(motion.names, rotations=True)
        hidden = {bones[bone] for bone in absent if bone in bones}
        names = tuple(f"x{i}" if i in hidden else name for i, name in enumerate(motion.names))
        motion = msgspec.structs.replace(motion, names=names)
        chunk = next(iter(motion.chunks()))
        chunk = type(chunk)(chunk.rotations[:FRAMES], chunk.translations[:FRAMES], chunk.times[:FRAMES])
        options = ReadOptions(skeleton=str(path) if "skeleton" in source_query else None)
        source = OscSource(parse_url("osc://127.0.0.1:0?profile=vmc" + source_query), options)
        sink = VmcFrameSink(parse_url(f"osc://127.0.0.1:{source.port}?profile=vmc{sink_query}"))
        sink.announce_motion(motion)
        heard = hear(source, lambda: sink.send_motion(chunk))
        sink.close()
        assert source.counters.malformed == 0
        return heard, motion, joint_positions(chunk, motion.parents), chunk

    return run


RECORDINGS = [
    "walk01.bvh",
    "bvh_test1.bvh",
    "bvh_test2.bvh",
    "test_freebvh.bvh",
    "cmu_12_01_walk.bvh",
    "131_01.bvh",
]


@pytest.mark.parametrize("name", RECORDINGS)
def test_a_bvh_comes_back_where_it_was_when_positions_are_sent(round_trip, data, name):
    heard, motion, truth, chunk = round_trip(data / "formats/bvh" / name)
    bones = mapped_bones(motion.names, rotations=True)
    skeleton = heard.metas[0].skeleton
    assert set(skeleton.names) == set(bones)
    assert skeleton.names[skeleton.root] == "Hips"
    columns = [bones[bone] for bone in skeleton.names]
    assert np.abs(heard.positions() - truth[:, columns]).max() < 1e-3
    assert heard.times() == pytest.approx(chunk.times, abs=1e-6)


ABSENT = (
    "Chest",
    "UpperChest",
    "Neck",
    "LeftShoulder",
    "RightLowerArm",
    "LeftUpperLeg",
    "RightFoot",
    "LeftToes",
)


@pytest.mark.parametrize("name", RECORDINGS)
def test_the_joints_that_remain_are_where_they_were_when_bones_are_absent(round_trip, data, name):
    heard, motion, truth, _ = round_trip(data / "formats/bvh" / name, absent=ABSENT)
    names = heard.metas[0].skeleton.names
    bones = mapped_bones(motion.names, rotations=True)
    assert len(names) >= 10
    assert not set(names) & set(ABSENT)
    assert np.abs(heard.positions() - truth[:, [bones[bone] for bone in names]]).max() < 1e-3


@pytest.mark.parametrize("name", ["walk01.bvh", "bvh_test1.bvh", "test_freebvh.bvh"])
def test_rotations_alone_give_the_same_places_with_the_files_skeleton(round_trip, data, name):
    path = data / "formats/bvh" / name
    heard, motion, truth, _ = round_trip(path, "&positions=no", f"&skeleton={path}")
    bones = mapped_bones(motion.names, rotations=True)
    rigid = [b for b in heard.metas[0].skeleton.names if not _bends_between(motion, bones, b)]
    columns = [heard.metas[0].skeleton.names.index(b) for b in rigid]
    error = np.abs(heard.positions()[:, columns] - truth[:, [bones[b] for b in rigid]]).max()
    assert len(rigid) >= 9
    assert error < 1e-3


def _bends_between(motion, bones, bone):
    """Return whether a joint that is no bone lies between a bone and the hips: its turns are not sent."""
    joint = motion.parents[bones[bone]]
    while joint >= 0:
        if joint not in bones.values():
            return True
        joint = motion.parents[joint]
    return False


def test_rotations_alone_turn_the_built_in_skeleton_alike(round_trip, data):
    heard, _, _, chunk = round_trip(data / "formats/bvh/walk01.bvh", "&positions=no")
    motion = open_motion(data / "formats/bvh/walk01.bvh")
    bones = mapped_bones(motion.names, rotations=True)
    world = chunk.rotations.copy()
    for joint, parent in enumerate(motion.parents):
        if parent >= 0:
            world[:, joint] = world[:, parent] @ world[:, joint]
    names = heard.metas[0].skeleton.names
    rest = rest_skeleton()
    hanging = [(names[parent], names[child]) for parent, child in heard.metas[0].skeleton.bones()]
    assert len(hanging) == len(names) - 1 >= 15
    for bone, child in hanging:
        got = heard.positions()[:, names.index(child)] - heard.positions()[:, names.index(bone)]
        expected = world[:, bones[bone]] @ (rest[child] - rest[bone])
        cosine = (got * expected).sum(1) / np.linalg.norm(got, axis=1) / np.linalg.norm(expected, axis=1)
        assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 0.1


def test_positions_without_rotations_are_sent_as_bones_that_do_not_turn(hear):
    from mossar_adapters.demo import DemoSource
    from mossar_adapters.source import Meta

    items = list(DemoSource.from_url("demo:?seconds=0.5", speed="max").items())
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    sink = VmcFrameSink(parse_url(f"osc://127.0.0.1:{source.port}?profile=vmc"))

    def send():
        for item in items:
            if isinstance(item, Meta):
                sink.announce(item)
            else:
                sink.send_frames(item)

    heard = hear(source, send)
    sink.close()
    truth = np.concatenate([item.positions for item in items[1:]])
    names = heard.metas[0].skeleton.names
    columns = [items[0].skeleton.index(name) for name in names]
    assert len(names) == 21
    assert np.abs(heard.positions() - truth[:, columns]).max() < 1e-5


_SNAKE = [re.sub(r"(.+)(Left|Right)", r"\2_\1", name) for name in KINECT_20.names]


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (_SNAKE, {"LeftUpperArm": "left_shoulder", "RightHand": "right_wrist", "LeftFoot": "left_ankle"}),
        (COCO_17.names, {"LeftUpperArm": "left_shoulder", "RightHand": "right_wrist", "Head": "nose"}),
        (BLAZEPOSE_33.names, {"RightLowerLeg": "right_knee", "LeftToes": "left_foot_index"}),
    ],
)
def test_joints_are_bones_by_the_names_that_moves_know(names, expected):
    names = [name.lower() if names is _SNAKE else name for name in names]
    positions = np.random.default_rng(1).normal(size=(3, len(names), 3)).astype(np.float32)
    bones = PositionBones(Skeleton(tuple(names), root=-1))
    pose = bones.pose(positions)
    parents = present_parents(pose.bones)
    places = pose.transforms[..., :3] / MIRROR[:3]
    for child, parent in enumerate(parents):
        if parent >= 0:
            places[:, child] += places[:, parent]
    for bone, joint in expected.items():
        assert places[:, pose.bones.index(bone)] == pytest.approx(positions[:, names.index(joint)], abs=1e-5)
    if "left_hip" in names and "hipcenter" not in names:
        hips = positions[:, [names.index("left_hip"), names.index("right_hip")]].mean(axis=1)
        assert places[:, pose.bones.index("Hips")] == pytest.approx(hips, abs=1e-5)


def bone(name, position=(0.0, 0.0, 0.0), turn=STILL):
    return encode("/VMC/Ext/Bone/Pos", "sfffffff", name, *position, *turn)


ROOT = encode("/VMC/Ext/Root/Pos", "sfffffffffffff", "root", 0, 0, 5, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0)
OK = encode("/VMC/Ext/OK", "i", 1)
BONES = ("Hips", "Spine", "Chest", "Neck", "Head", "LeftUpperArm", "LeftLowerArm", "LeftHand")


def at(seconds):
    return encode("/VMC/Ext/T", "f", seconds)


def bones(frame):
    return [bone(name, (0.0, 0.1 + 0.001 * frame, 0.0)) for name in BONES]


def reference(frame):
    all_bones = bones(frame)
    return [bundle(all_bones[:5]), bundle([ROOT, bundle(all_bones[5:]), OK, at(frame / 60)])]


SENDERS = {
    "bundles as the reference": reference,
    "time and OK last": lambda k: [*bones(k), ROOT, OK, at(k / 60)],
    "time before OK": lambda k: [*bones(k), ROOT, at(k / 60), OK],
    "time first": lambda k: [at(k / 60), ROOT, *bones(k), OK],
    "time first, no OK": lambda k: [at(k / 60), *bones(k)],
    "time last, no OK": lambda k: [*bones(k), at(k / 60)],
    "never a time": lambda k: [ROOT, *bones(k), OK],
    "bones only": bones,
    "one bundle": lambda k: [bundle([*bones(k), ROOT, OK, at(k / 60)])],
    "root first, bones only": lambda k: [ROOT, *bones(k)],
}


@pytest.mark.parametrize("sender", SENDERS)
def test_frames_end_where_they_should_whatever_the_sender_does(hear, sender):
    source = OscSource(parse_url("osc://127.0.0.1:0"), ReadOptions(fps=60.0))
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send():
        for frame in range(20):
            for datagram in SENDERS[sender](frame):
                wire.sendto(datagram, ("127.0.0.1", source.port))

    heard = hear(source, send)
    wire.close()
    positions = heard.positions()
    assert len(positions) == 20
    assert np.isfinite(positions).all()
    steps = np.diff(positions, axis=1)[:, :4, 1]
    assert steps == pytest.approx(np.repeat(0.1 + 0.001 * np.arange(20), 4).reshape(20, 4), abs=1e-6)
    assert np.array_equal(heard.times(), np.arange(20) / 60)


def test_fingers_eyes_and_jaw_are_passed_over(hear):
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    other = [bone(name) for name in ("LeftIndexProximal", "LeftEye", "Jaw", "LastBone")]
    blend = encode("/VMC/Ext/Blend/Val", "sf", "Joy", 0.5)

    def send():
        for frame in range(4):
            for datagram in [*bones(frame), *other, blend, OK, at(frame / 30)]:
                wire.sendto(datagram, ("127.0.0.1", source.port))

    heard = hear(source, send)
    wire.close()
    assert heard.metas[0].skeleton.names == BONES
    assert source.counters.malformed == source.counters.ignored == 0


def test_a_lost_datagram_makes_its_bones_missing_and_nothing_else(hear):
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send():
        for frame in range(10):
            for part, datagram in enumerate(reference(frame)):
                if (frame, part) != (5, 1):
                    wire.sendto(datagram, ("127.0.0.1", source.port))

    heard = hear(source, send)
    wire.close()
    positions = heard.positions()
    assert len(positions) == 10
    missing = np.isnan(positions).any(axis=2)
    assert missing[5].tolist() == [False] * 5 + [True] * 3
    assert missing.sum() == 3
    assert np.diff(heard.times()) == pytest.approx(np.full(9, 1 / 60), abs=0.02), "one clock throughout"


def test_absent_bones_hang_their_children_on_the_nearest_ancestor():
    pose = VmcPose(("Hips", "Chest", "Head"), {})
    assert pose.skeleton.parents == (-1, 0, 1)
    table = np.array([(0, 1, 0, *STILL), (0, 0.3, 0, 0, 0, HALF, HALF), (0, 0.4, 0, *STILL)])
    places = pose.positions(table, None)
    # Unity turns clockwise about z when seen from the front of a left-handed system: mirrored, head goes to +x.
    assert places == pytest.approx(np.array([(0, 1, 0), (0, 1.3, 0), (0.4, 1.3, 0)]))


def test_handedness_is_flipped_for_places_and_turns_alike():
    pose = VmcPose(("Hips", "LeftUpperArm", "LeftLowerArm"), {})
    quarter = (0.0, HALF, 0.0, HALF)  # about +y
    table = np.array([(0, 1, 0, *quarter), (-0.2, 0.5, 0, *STILL), (-0.3, 0, 0, *STILL)])
    # Unity: +y turns +z towards +x, -x to +z.
    left_handed = np.array([(0, 1, 0), (0, 1.5, 0.2), (0, 1.5, 0.5)])
    assert pose.positions(table, None) == pytest.approx(left_handed * (-1, 1, 1))


def test_the_root_moves_and_turns_the_whole():
    pose = VmcPose(("Hips", "Head"), {})
    root = (1.0, 0.0, 2.0, 0.0, 1.0, 0.0, 0.0)  # half a turn about y
    table = np.array([(0, 1, 0.5, *STILL), (0.1, 0.5, 0, *STILL)])
    assert pose.positions(table, root) == pytest.approx(np.array([(-1, 1, 1.5), (-0.9, 1.5, 1.5)]))


def test_quaternions_of_any_length_become_rotations():
    turns = rotations_of(np.array([(0, 0, 3, 3.0), (0, 0, 0, 0.1)]))
    assert turns[0] == pytest.approx(np.array([(0, -1, 0), (1, 0, 0), (0, 0, 1)]), abs=1e-12)
    assert turns[1] == pytest.approx(np.eye(3))


def test_times_rounded_on_the_way_are_made_exact():
    for k in (1, 7, 1144, 100_000):
        assert exact_time(float(np.float32(k / 120)), None) == k / 120
        assert exact_time(float(np.float32(k / 33)), 33.0) == k / 33
    assert exact_time(0.123456, None) == 0.123456


def test_an_idle_gap_closes_a_frame():
    frames = VmcFrames()
    assert frames.bone("Hips", (0.0,) * 7, 0.0) == []
    assert frames.idle(0.001) == []
    assert frames.idle(0.2) == [ClosedFrame({"Hips": (0.0,) * 7}, 0.0)]
    assert frames.idle(0.4) == []


def test_a_second_sender_tears_no_take_of_the_first(hear):
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    first, second = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))

    def send():
        for frame in range(60):
            for datagram in reference(frame):
                first.sendto(datagram, ("127.0.0.1", source.port))
            if frame >= 30:  # other bones, between those of the first
                others = [bone(name, (0.0, 0.2, 0.0)) for name in BONES[:-1]]
                second.sendto(bundle([*others, OK, at(frame / 60)]), ("127.0.0.1", source.port))

    heard = hear(source, send)
    for wire in (first, second):
        wire.close()
    assert heard.performers() == ["p1", "p2"]
    assert [len(meta.skeleton) for meta in heard.metas if meta.performer == "p1"] == [len(BONES)]
    assert heard.count("p1") >= 59


def test_a_sender_that_restarts_keeps_its_name_and_a_second_one_gets_its_own(hear):
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    wires = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]

    def speak(wire, count):
        for frame in range(count):
            for datagram in reference(frame):
                wire.sendto(datagram, ("127.0.0.1", source.port))

    def send():
        speak(wires[0], 4)
        speak(wires[1], 4)  # took over from the first
        for _ in range(5):  # two at a time
            speak(wires[1], 1)
            speak(wires[2], 1)

    heard = hear(source, send)
    other = [name for name in heard.performers() if name != "p1"]
    assert heard.count("p1") >= 13
    assert other == ["p2"]
    for wire in wires:
        wire.close()


UNREAL = (
    "pelvis spine_01 spine_02 spine_03 spine_04 spine_05 neck_01 head clavicle_l upperarm_l lowerarm_l hand_l thigh_l calf_l "
    "foot_l ball_l"
)


@pytest.mark.parametrize(
    ("names", "trunk"),
    [
        (UNREAL, "spine_01 spine_03 spine_05"),
        (
            "Hips Spine Spine1 Spine2 Spine3 Neck Head LeftArm LeftForeArm LeftHand LeftUpLeg",
            "Spine Spine1 Spine2",
        ),
        (
            "Pelvis Spine1 Spine2 Spine3 Neck Head L_Shoulder L_Elbow L_Wrist L_Hip L_Knee",
            "Spine1 Spine2 Spine3",
        ),
        ("hip abdomen chest neck head lShldr lForeArm lHand lThigh lShin lFoot", "abdomen chest"),
        ("下半身 上半身 上半身2 首 頭 左腕 左ひじ 左手首 左足 左ひざ 左足首", "上半身 上半身2"),
    ],
)
def test_bones_are_known_in_the_names_of_any_program(names, trunk):
    joints = names.split()
    found = {bone: joints[joint] for bone, joint in mapped_bones(joints, rotations=True).items()}
    assert [found[bone] for bone in ("Spine", "Chest", "UpperChest") if bone in found] == trunk.split()
    assert found["Hips"] == joints[0]
    assert found["LeftUpperArm"] in {"upperarm_l", "LeftArm", "L_Shoulder", "lShldr", "左腕"}
    assert found["LeftUpperLeg"] in {"thigh_l", "LeftUpLeg", "L_Hip", "lThigh", "左足"}


ARM = ("Hips", "Spine", "LeftUpperArm", "LeftLowerArm", "LeftHand")


def _table(*positions):
    return np.array([(*xyz, *STILL) for xyz in positions])


def test_bones_without_positions_have_those_of_rest_beside_bones_with_positions():
    pose = VmcPose(ARM, {})
    zero = (0, 0, 0)
    mixed = pose.positions(_table((0, 0.9, 0), (0, 0.2, 0), zero, zero, zero), None)
    rest = VmcPose(ARM, {}).positions(_table((0, 0.9, 0), zero, zero, zero, zero), None)
    assert mixed[1] == pytest.approx((0, 1.1, 0)), "as sent"
    assert mixed[2:] - mixed[1] == pytest.approx(rest[2:] - rest[1])


def test_bones_that_lie_in_their_parents_stay_there_if_others_have_positions():
    places = VmcPose(ARM, {}).positions(
        _table((0, 0.9, 0), (0, 0, 0), (-0.2, 0.4, 0), (-0.3, 0, 0), (-0.2, 0, 0)), None
    )
    assert places[1] == pytest.approx((0, 0.9, 0))


@pytest.mark.parametrize("hips", [True, False])
def test_half_of_the_bones_in_each_frame_are_one_take_with_all_bones(hips):
    decoder, items = OscDecoder(parse_url("osc://127.0.0.1:0")), []
    for k in range(120):
        for i, bone in enumerate(BONES):
            if (i + k) % 2 or (hips and bone == "Hips"):
                row = (0.01 * i, 0.1 + 0.1 * i, 0.001 * k, *STILL)
                items += decoder.receive(_datagram(encode(BONE, "sfffffff", bone, *map(float, row)), k / 60))
        items += decoder.receive(_datagram(encode("/VMC/Ext/T", "f", k / 60), k / 60))
    items += decoder.idle(9.0)
    assert sum(isinstance(item, Meta) for item in items) == 1
    positions = np.concatenate([item.positions for item in items if isinstance(item, Frames)])
    assert positions.shape == (120, len(BONES), 3)
    assert np.isfinite(positions[1:]).all()


def test_a_bone_that_stays_away_is_missing_in_the_end():
    decoder, items = OscDecoder(parse_url("osc://127.0.0.1:0")), []
    for k in range(120):
        for i, bone in enumerate(BONES):
            if bone != "Head" or k < 30:
                row = (0.01 * i, 0.1 + 0.1 * i, 0.001 * k, *STILL)
                items += decoder.receive(_datagram(encode(BONE, "sfffffff", bone, *map(float, row)), k / 60))
        items += decoder.receive(_datagram(encode("/VMC/Ext/T", "f", k / 60), k / 60))
    positions = np.concatenate([item.positions for item in items if isinstance(item, Frames)])
    missing = np.isnan(positions[:, BONES.index("Head"), 0])
    assert not missing[:30].any()
    assert missing[30 + 31 :].all()


def _datagram(data, arrival):
    return Datagram(data, "127.0.0.1", 9000, arrival)
