"""Taking: movements from rest to rest, pauses within them included, of performers that sway and sensors that jitter."""

import numpy as np
import pytest

from mossar_adapters.demo.body import NEUTRAL, SKELETON, joint_positions, pose
from mossar_adapters.demo.script import Script, Stance
from mossar_adapters.demo.strokes import shaking
from mossar_adapters.source import Meta
from mossar_stream import Frames
from mossar_tools.taking import AWAY, LONGEST, MovementTaker, TimedTaker

FPS = 30.0
RAISED = {"l_azimuth": 1.2, "l_elevation": 0.6, "l_reach": 0.42, "l_swivel": -0.2}
LOW = {"hips_y": 0.58, "hips_z": -0.17, "hips_pitch": 0.42, "torso_pitch": 0.33}


def wave(script, pause=0.0):
    script.to(0.0, 0.4, **RAISED)
    script.sway(0.4 + pause, 2.4 + pause, shaking(4), l_azimuth=-0.35, l_swivel=0.1)
    script.back(2.4 + 2 * pause, 2.8 + 2 * pause)


def hold(script, seconds=1.5):
    script.to(0.0, 0.7, l_azimuth=1.3, l_elevation=0.1)
    script.back(0.7 + seconds, 1.4 + seconds)


def squats(script, count=1, pause=0.0):
    for k in range(count):
        begin = k * (1.6 + pause)
        script.to(begin, begin + 0.8, **LOW)
        script.back(begin + 0.8 + pause, begin + 1.6 + pause)


def kick(script):
    script.to(0.0, 0.3, r_y=0.5, r_z=0.4, r_pitch=0.3)
    script.to(0.3, 0.55, r_y=0.9, r_z=0.92, r_pitch=-0.8)
    script.back(0.6, 1.1)


def twice_up(script):
    script.to(0.0, 0.6, r_azimuth=0.2, r_elevation=0.0)
    script.to(1.2, 1.7, r_elevation=1.3)
    script.back(2.4, 3.1)


def raise_arm(script):
    script.to(0.0, 0.8, l_azimuth=1.3, l_elevation=1.2)


def scratch(script):
    script.to(0.0, 0.3, l_elevation=-1.3)
    script.back(0.3, 0.6)


MOVES = {
    "a wave": wave,
    "a wave with pauses": lambda script: wave(script, 0.7),
    "a held arm": hold,
    "a long held arm": lambda script: hold(script, 2.5),
    "a squat": squats,
    "a squat held below": lambda script: squats(script, 1, 1.0),
    "three squats": lambda script: squats(script, 3),
    "three squats with short rests": lambda script: squats(script, 3, 0.3),
    "a kick": kick,
    "an arm raised in two steps": twice_up,
}


class Stage:
    """A performer who moves and rests, and what is taken of it."""

    def __init__(self, noise=0.0, sway=0.005, seed=1):
        self._rng = np.random.default_rng(seed)
        self._noise, self._sway = noise, sway
        self._pose = Stance().at_ease()
        self._parts, self._count = [], 0
        self.true = []

    def rest(self, seconds):
        self._append(np.tile(self._pose, (round(seconds * FPS), 1)))
        return self

    def do(self, move):
        script = Script(Stance(), 0.0, 1.0, pose(NEUTRAL))
        script.goal = self._pose.copy()
        move(script)
        times = np.arange(0.0, script.end + 1 / FPS, 1 / FPS)
        poses = np.tile(self._pose, (len(times), 1)) + sum(stroke.at(times) for stroke in script.strokes)
        self.true.append((self._count / FPS, (self._count + len(times)) / FPS))
        self._append(poses)
        self._pose = poses[-1]
        return self

    def _append(self, poses):
        self._parts.append(poses)
        self._count += len(poses)

    def positions(self, since=0.0):
        poses = np.concatenate(self._parts)
        times = np.arange(len(poses)) / FPS
        found = joint_positions(poses)
        rates = self._rng.uniform(0.2, 0.9, (len(SKELETON), 3))
        found += self._sway * np.sin(2 * np.pi * rates * times[:, None, None])
        found += self._rng.normal(0.0, self._noise, found.shape)
        return found[round(since * FPS) :].astype(np.float32)


def play(taker, positions, chunk=5, times=None):
    times = np.arange(len(positions)) / FPS if times is None else times
    taker.announce(Meta("p1", SKELETON))
    for at in range(0, len(positions), chunk):
        part = slice(at, at + chunk)
        taker.send_frames(Frames(positions[part], times[part], None, "p1"))
    taker.close()


def taken(positions, **keywords):
    movements, said = [], []
    play(MovementTaker(movements.append, said.append), positions, **keywords)
    return movements, said


@pytest.mark.parametrize("noise", [0.0, 0.006], ids=["clean", "noisy"])
@pytest.mark.parametrize("name", MOVES)
def test_a_move_with_its_pauses_is_one_movement(name, noise):
    stage = Stage(noise).rest(1.5)
    for _ in range(3):
        stage.do(MOVES[name]).rest(2.0)
    movements, said = taken(stage.positions())
    assert [len(movements), said] == [3, []]
    for movement, (begin, end) in zip(movements, stage.true, strict=True):
        assert movement.begin == pytest.approx(begin, abs=0.3)
        assert movement.end == pytest.approx(end, abs=0.3)
        first, last = movement.frames
        assert (last - first) / movement.fps == pytest.approx(movement.seconds, abs=0.07)
        assert first > 0
        assert last < len(movement.positions) - 1


def test_a_performer_who_sways_like_a_boxer_rests_compared_with_a_kick():
    stage = Stage(0.003, sway=0.02).rest(2.0)
    for _ in range(3):
        stage.do(kick).rest(2.0)
    movements, _ = taken(stage.positions())
    assert [movement.begin for movement in movements] == pytest.approx(
        [begin for begin, _ in stage.true], abs=0.3
    )


@pytest.mark.parametrize("since", [0.4, 0.8, 1.2])
def test_what_goes_on_when_the_stream_begins_is_no_example(since):
    stage = Stage().do(squats).rest(2.0).do(squats).rest(2.0)
    movements, said = taken(stage.positions(since))
    assert [movement.begin + since for movement in movements] == pytest.approx([stage.true[1][0]], abs=0.2)
    assert said == ["not taken: it did not begin at rest; rest, do it, rest"]


def test_a_move_that_ends_in_another_pose_is_over_after_a_longer_rest():
    stage = Stage().rest(1.5).do(raise_arm).rest(AWAY + 1.0)
    (movement,), _ = taken(stage.positions())
    assert (movement.begin, movement.end) == pytest.approx(stage.true[0], abs=0.3)
    nothing = []
    stage = Stage().rest(1.5).do(raise_arm).rest(AWAY - 0.5)
    taker = MovementTaker(nothing.append, print)
    taker.announce(Meta("p1", SKELETON))
    positions = stage.positions()
    taker.send_frames(Frames(positions, np.arange(len(positions)) / FPS, None, "p1"))
    assert nothing == []


def test_sway_and_small_movements_are_none():
    stage = Stage(0.004, sway=0.02).rest(3.0).do(scratch).rest(3.0).do(scratch).rest(30.0)
    assert taken(stage.positions()) == ([], [])


def test_movements_do_not_depend_on_how_frames_are_chopped():
    stage = Stage(0.004).rest(2.0).do(wave).rest(2.0).do(kick).rest(2.0)
    positions = stage.positions()
    found = [[(m.begin, m.end) for m in taken(positions, chunk=chunk)[0]] for chunk in (1, 7, 1000)]
    assert found[0] == found[1] == found[2]
    assert len(found[0]) == 2


def test_a_glitch_of_the_sensor_hides_no_movement():
    stage = Stage().rest(2.0).do(kick).rest(2.0)
    positions = stage.positions()
    positions[20] += np.array([3.0, 0.0, 0.0], np.float32)
    positions[20, 0] = positions[19, 0]
    movements, _ = taken(positions)
    assert movements[-1].begin == pytest.approx(stage.true[0][0], abs=0.3)


def test_frames_that_were_missing_begin_anew():
    stage = Stage().rest(2.0).do(wave).rest(2.0).do(kick).rest(2.0)
    positions = stage.positions()
    times = np.arange(len(positions)) / FPS
    times[round(3.0 * FPS) :] += 1.0
    movements, said = taken(positions, times=times)
    assert [movement.begin for movement in movements] == pytest.approx([stage.true[1][0] + 1.0], abs=0.2)
    assert len(said) == 1


def test_a_movement_without_end_is_said_and_forgotten():
    stage = Stage().rest(1.5).do(lambda script: squats(script, 20)).rest(2.0).do(kick).rest(2.0)
    movements, said = taken(stage.positions())
    assert said[0].startswith(f"more than {LONGEST:g} s of movement were not taken")
    assert movements[-1].begin == pytest.approx(stage.true[1][0], abs=0.2)
    assert len(movements) == 1


def test_a_fixed_length_needs_no_rest():
    stage = Stage().do(lambda script: squats(script, 12)).rest(0.5)
    stretches, said = [], []
    play(TimedTaker(stretches.append, said.append, seconds=4.0, lead=3.0), stage.positions())
    assert [stretch.begin for stretch in stretches] == pytest.approx([3.0, 10.0], abs=0.05)
    assert [stretch.seconds for stretch in stretches] == pytest.approx([4.0, 4.0], abs=0.05)
    assert said == ["now, for 4 s"] * len(said)
    assert stretches[0].frames == (0, len(stretches[0].positions) - 1)
