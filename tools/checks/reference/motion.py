"""The rule of level `motion` on whole arrays, in plain Python: the oracle for decisions of streams by evidence.

Nothing here is quick or incremental. `evidence.pxi`, `scales.pxi`, `repetition_labels.pxi` and `noise.pxi` explain the
features; constants are theirs, the rest is written anew. The counted repetitions are an input. All joints must be there
in all frames.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator
from functools import cached_property
from operator import mul
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from checks.reference.algorithms import localise
from checks.reference.counted import Counted
from checks.reference.motion_velocity import SIG_THRESHOLD, velocity
from mossar_stream.core import kernels
from mossar_stream.core.kernels import ANALYSIS_INTERVAL, LONGEST_RATIO, LONGEST_SILENCE, MARGIN
from mossar_stream.similarity.evidence import WEIGHTS, Weights
from mossar_stream.skeleton import Skeleton

HOLD = 1.4  # s until a key frame is decided
CAPACITY = 20  # undecided key frames
CERTAIN = math.log(2.0**kernels.CERTAIN - 1.0)  # log odds of a key frame that ends a repetition
MAX_SPEED, MAX_GAP = 15.0, 0.25  # m/s, s; settings
Array = NDArray[np.float64]


class Candidate(NamedTuple):
    """A key frame of Algorithm 2, and its features at the confirmation."""

    frame: int  # where the segment after it begins
    confirmed: int  # frame
    reported: int  # reported frame
    speed: float  # m/s, lowest since the candidate
    rest_distance: float  # A
    extent: float  # m, A
    usual: float  # m/s, V
    tempo: float
    noise: float  # m/s


class Motion:
    """The features of a recording, independent of the weights.

    Args:
        positions: (n, J, 3) m.
        fps: Hz.
        skeleton: Their joints.
        counted: The counted repetitions; see counted.py.
    """

    def __init__(self, positions: Array, fps: float, skeleton: Skeleton, counted: Counted) -> None:
        root = skeleton.root
        self.taken = taken_frames(np.arange(len(positions)) / fps)
        taken = np.asarray(positions, dtype=np.float64)[self.taken]
        poses = localise(without_leaps(taken, self.taken / fps), root)
        self.moving_joints = max(1, poses.shape[1] - (1 if root >= 0 else 0))
        self.times = self.taken / fps
        self.dt = np.diff(self.times, prepend=0.0)
        self.poses = filtered(poses, self.dt)
        self.speeds = joint_speeds(self.poses, self.times)
        self.speed = np.sqrt((self.speeds**2).sum(axis=1) / self.moving_joints)
        heard = velocity(poses, self.times, self.moving_joints, self.speed)
        self.curve, self.range, self.noise, self.loud = heard
        self.usual = usual_speeds(self.speed, self.dt)
        self.steadiness = steadiness(self.speed < kernels.SLOW * self.usual, self.dt)
        self.extent, self.away = surroundings(self)
        self.sums = _sums(self)
        self.candidates = list(self._candidates())
        self.counted = counted
        self._known: dict[tuple[int, int, int], list[float] | None] = {}

    def _candidates(self) -> Iterator[Candidate]:
        """Yield the key frames of Algorithm 2 with their features."""
        before = 0
        for frame, found, confirmed, time in algorithm_2(self.curve, SIG_THRESHOLD * self.range, self.times):
            marks = np.arange(found)[::-1]
            earlier = kernels.EARLIER_IN_NOISE if self.loud[found] else kernels.EARLIER
            reported = int(marks[np.argmin(np.abs(self.times[marks] - (time - earlier)))])
            before = reported if before < reported else frame
            extent, usual = self.extent[confirmed], self.usual[confirmed]
            tempo = slowness(extent / usual, self.steadiness[confirmed])
            rest_distance = self.away[found - 1] / extent
            speed = self.speed[found - 1 : confirmed].min()
            noisy = self.noise[confirmed]
            yield Candidate(frame, confirmed, before, speed, rest_distance, extent, usual, tempo, noisy)

    def evidence(self, number: int, begin: int, end: int) -> list[float] | None:
        """Return the five kinds of evidence for a candidate between two frames, in the order of `Weights`.

        None where a segment is empty or its peak does not rise above the sensor's noise.
        """
        if (begin, number, end) not in self._known:
            self._known[begin, number, end] = self._evidence(self.candidates[number], begin, end)
        return self._known[begin, number, end]

    def _evidence(self, candidate: Candidate, begin: int, end: int) -> list[float] | None:
        k, usual = candidate.frame, candidate.usual
        durations = self.sums[0]
        if min(durations[k] - durations[begin], durations[end] - durations[k]) <= 0.0:
            return None
        peak = min(self.speed[begin:k].max(), self.speed[k:end].max())
        if peak < kernels.PEAK_ABOVE_NOISE * candidate.noise:
            return None
        floor = (kernels.POSE_FLOOR * candidate.extent) ** 2
        change = self._terms(begin, end, floor) - self._terms(begin, k, floor) - self._terms(k, end, floor)
        change /= self.moving_joints * candidate.tempo
        pose, speed = np.minimum(change, kernels.MOST_CHANGE / candidate.tempo)
        least = kernels.SPEED_FLOOR_OF_ODDS * usual
        stop = min(kernels.MOST_PROMINENT, np.log((peak + least) / (candidate.speed + least)))
        rest = np.log((candidate.speed + least) / (2.0 * usual))
        return [float(kind) for kind in (pose, speed, stop, rest, -candidate.rest_distance)]

    def _terms(self, begin: int, end: int, floor: float) -> Array:
        """Return T Σ log(σ² + floor) of the frames begin … end - 1, of poses and of log speeds."""
        time, pose, pose_squares, speed, speed_squares = (total[end] - total[begin] for total in self.sums)
        variance = np.maximum(pose_squares / time - (pose / time) ** 2, 0.0).mean(axis=1)
        of_speed = np.maximum(speed_squares / time - (speed / time) ** 2, 0.0)
        terms = np.log(variance + floor).sum(), np.log(of_speed + kernels.SPEED_FLOOR).sum()
        return time * np.array(terms)  # type: ignore[no-any-return]

    def final(self, weights: Weights = WEIGHTS) -> list[int]:
        """Return the reported frames of the final key frames, frames of the recording."""
        finals: list[int] = []
        left, undecided, noted = 0, list[int](), 0
        for t, time in enumerate(self.times):
            while noted < len(self.candidates) and self.candidates[noted].confirmed <= t:
                undecided.append(noted)
                noted += 1
            while undecided and (
                len(undecided) > CAPACITY or time >= self._time(undecided[0]) + self.holds[t]
            ):
                number = undecided[0]
                if number in self._kept(undecided, left, t + 1, weights):
                    finals.append(self._located(undecided, finals, t + 1))
                    left = self.candidates[number].frame
                undecided.pop(0)
        kept = self._kept(undecided, left, len(self.times), weights)
        for place, number in enumerate(undecided):
            if number in kept:
                finals.append(self._located(undecided[place:], finals, len(self.times)))
        return self.taken[np.array(finals, dtype=np.int64)].tolist()  # type: ignore[no-any-return]

    def reported(self) -> list[int]:
        """Return the reported frames of the key frames that are reported when Algorithm 2 accepts them."""
        reported, first, before, speed = [], 0, self.times[0] + kernels.SPEED_SETTLING, 0.0
        for c in self.candidates:
            since = np.arange(first, c.confirmed + 1)
            peak = self.speed[since[self.times[since] > before + MARGIN]].max(initial=0.0)
            rose = peak >= max(kernels.REPORTED_ABOVE_NOISE * c.noise, kernels.RISEN * c.speed)
            interval = kernels.SHORT_INTERVAL if c.speed <= kernels.RISEN * speed else kernels.INTERVAL
            apart = self.times[c.frame] - before >= interval - MARGIN
            if apart and rose and c.speed <= kernels.QUICK * c.usual:
                reported.append(c.reported)
                first, before, speed = c.confirmed + 1, self.times[c.frame], c.speed
        return self.taken[np.array(reported, dtype=np.int64)].tolist()  # type: ignore[no-any-return]

    @cached_property
    def own_time(self) -> Array:
        """τ at each frame, s."""
        return np.clip(self.extent / self.usual, kernels.LEAST_OWN_TIME, kernels.MOST_OWN_TIME)

    @cached_property
    def holds(self) -> Array:
        """Age at which a key frame is decided, at each frame, s: larger for slow performers until a repetition is counted."""
        counts = np.searchsorted(self.counted.since, self.times, "right") - 1
        is_counted = np.array([len(self.counted.tables[count]) > 0 for count in counts])
        slowness = np.minimum(self.extent, kernels.HAND) / self.usual
        more = kernels.WAITS_MORE * np.maximum(slowness - kernels.WAITS_FROM, 0.0)
        waits = np.minimum(HOLD + more, kernels.WAITS_AT_MOST * HOLD)
        return np.where(is_counted, HOLD, waits)

    @cached_property
    def dwells(self) -> list[tuple[float, float]]:
        """Times in which the performer was slow, (begin, end), s."""
        found: list[tuple[float, float]] = []
        for time in self.times[1:][self.speed[1:] < kernels.SLOW * self.usual[1:]]:
            if found and time - found[-1][1] <= kernels.DWELL_GAP + MARGIN:
                found[-1] = found[-1][0], float(time)
            else:
                found.append((float(time), float(time)))
        return found

    def _located(self, undecided: list[int], finals: list[int], until: int) -> int:
        """Return the final place of the oldest key frame; one that ends a repetition moves to the middle of the pause."""
        number = undecided[0]
        here, (label, known) = self.candidates[number].reported, self.labels[number]
        if label != kernels.ENDS or known >= until:
            return here
        time, now = self._reported(number), self.times[until - 1]
        best, least = None, kernels.NEAR_DWELL
        for begin, end in self.dwells[: bisect_right(self.dwells, (now, math.inf))]:
            off = max(begin - time, time - min(end, now), 0.0)
            if off < least - MARGIN:
                best, least = 0.5 * (begin + min(end, now)) - kernels.LATE_DWELL, off
        if best is None:
            return here
        middle = int(np.argmin(np.abs(self.times - best)))
        following = next(
            (other for other in undecided[1:] if self._label_at(other, until) != kernels.WITHIN), None
        )
        until = until if following is None else self.candidates[following].reported
        return middle if (finals[-1] if finals else 0) < middle < until else here

    def _label_at(self, number: int, end: int) -> int:
        """Return the label of a candidate by the state before a frame."""
        label, known = self.labels[number]
        return label if known < end else int(kernels.UNLABELLED)

    def _time(self, number: int) -> float:
        return float(self.times[self.candidates[number].frame])

    def _reported(self, number: int) -> float:
        return float(self.times[self.candidates[number].reported])

    def _kept(self, numbers: list[int], left: int, end: int, weights: Weights) -> set[int]:
        """Return the undecided key frames that stand at the level (Algorithm 3)."""
        kept = list(numbers)
        while kept:
            bounds = [left, *(self.candidates[number].frame for number in kept), end]
            between = zip(kept, bounds, bounds[2:], strict=False)
            odds = [self._odds(number, begin, after, end, weights) for number, begin, after in between]
            x = odds.index(min(odds))
            if odds[x] >= 0.0:  # line 15; β is the strength where odds are even
                break
            kept.pop(x)
        return set(kept)

    def _odds(self, number: int, begin: int, after: int, end: int, weights: Weights) -> float:
        """Return the log odds of a candidate between two frames, as the label of it leaves them before `end`."""
        label = self._label_at(number, end)
        if label == kernels.WITHIN:
            return -math.inf
        found = self.evidence(number, begin, after)
        odds = -math.inf if found is None else sum(map(mul, weights, found)) - weights.bias
        return max(odds, CERTAIN) if label == kernels.ENDS else odds

    @cached_property
    def labels(self) -> list[tuple[int, int]]:
        """The label of each candidate, and the frame at which it is known, in processed frames."""
        confirmed, last = [candidate.confirmed for candidate in self.candidates], -np.inf
        found = []
        for number in range(len(confirmed)):
            is_due = self.times >= self._time(number) + self.holds
            due = int(np.argmax(is_due)) if is_due.any() else len(self.times)
            known = min(max(due, confirmed[number]), len(self.times) - 1)
            moment = self.times[known] if due < len(self.times) else np.inf
            counted = self.counted.tables[np.searchsorted(self.counted.since, moment, "right") - 1]
            longest = max(kernels.LONGEST_PERIOD, kernels.LONGEST_IN_OWN_TIME * self.own_time[known])
            noted = range(bisect_right(confirmed, known))
            if len(counted) > 0:
                label, last = self._label(number, noted, counted, last, longest)
            elif self.steadiness[known] >= kernels.LEAST_STEADY:
                label, last = self._label_by_way(number, noted, self.counted.ways[self.taken[known]], last)
            else:
                label = kernels.UNLABELLED
            found.append((label, known))
        return found

    def _label(
        self, number: int, noted: range, counted: Array, last: float, longest: float
    ) -> tuple[int, float]:
        """Return the label of a candidate, and when the last repetition ended; `longest` is the longest period, s."""
        time = self._reported(number)
        period = _period_at(counted, time)
        if not 0.0 < period <= longest + MARGIN:
            return kernels.UNLABELLED, last

        def cost(other: int) -> float:
            off = _off_bound(counted, self._reported(other)) / period
            return self._unlike_end(other) + kernels.OFF_BOUND * off

        near = [i for i in noted if abs(self._reported(i) - time) <= 0.5 * period + MARGIN]
        too_soon = time - last < kernels.NEAREST_END * period - MARGIN
        if min(near, key=cost) != number or too_soon:
            return kernels.WITHIN, last
        return kernels.ENDS, time

    def _label_by_way(self, number: int, noted: range, way: Array, last: float) -> tuple[int, float]:
        """Return the same before anything is counted, by the latest way out and back: see `Counted.ways`."""
        begin, end, leaves = way
        time = self._reported(number)
        if begin + MARGIN < time < end - MARGIN:
            return kernels.WITHIN, last
        until = min(leaves, end + (end - begin)) if end < math.inf else -math.inf
        after = [i for i in noted if end - MARGIN <= self._reported(i) < until - MARGIN]
        if number not in after:
            return kernels.UNLABELLED, last
        if last >= end - MARGIN or min(after, key=self._unlike_end) != number:
            return kernels.WITHIN, last
        return kernels.ENDS, time

    def _unlike_end(self, number: int) -> float:
        """Return how unlike the end of a repetition a candidate is, in log odds."""
        c = self.candidates[number]
        speed = np.log(c.speed / c.usual + kernels.SPEED_FLOOR_OF_ODDS)
        return float(WEIGHTS.rest_distance * c.rest_distance + (WEIGHTS.stop - WEIGHTS.rest) * speed)


def _period_at(counted: Array, time: float) -> float:
    """Return the period of the even bout that a time lies in, or goes on to, s; 0 if it lies in none."""
    before = counted[counted[:, 0] <= time + MARGIN]
    if not len(before):
        return 0.0
    _, end, period, _ = before[-1]
    is_last = len(before) == len(counted)
    silence = LONGEST_SILENCE * period + ANALYSIS_INTERVAL if is_last else 0.0
    goes_on = time <= end + silence + MARGIN
    return float(period) if goes_on and _is_even(counted, len(before) - 1) else 0.0


def _is_even(counted: Array, place: int) -> bool:
    """Return whether all periods of a repetition's bout are alike."""
    bouts = np.cumsum(counted[:, 3] == 1)
    periods = counted[bouts == bouts[place], 2]
    return bool(periods.max() <= LONGEST_RATIO * periods.min() + MARGIN)


def _off_bound(counted: Array, time: float) -> float:
    """Return the distance of a time from the nearest real or expected end of a repetition, s."""
    _, end, period, _ = counted[-1]
    bounds = [*counted[:, 0], *counted[:, 1], end + period * max(0.0, np.rint((time - end) / period))]
    return float(np.abs(np.array(bounds) - time).min())


def without_gaps(positions: Array) -> Array:
    """Return positions with missing joints on straight lines between their visible places; 0 for joints never seen."""
    filled = np.array(positions, dtype=np.float64)
    frames = np.arange(len(filled))
    for values in filled.reshape(len(filled), -1).T:
        missing = np.isnan(values)
        if missing.any() and not missing.all():
            values[missing] = np.interp(frames[missing], frames[~missing], values[~missing])
    return np.nan_to_num(filled)


def without_leaps(positions: Array, times: Array) -> Array:
    """Return positions with joints that are faster than people held where they were, for a while."""
    held, seen = positions.copy(), np.full(positions.shape[1], times[0])
    for t in range(1, len(times)):
        lasted = times[t] - seen
        leaps = np.linalg.norm(positions[t] - held[t - 1], axis=1) > MAX_SPEED * lasted
        leaps &= lasted <= MAX_GAP
        held[t][leaps] = held[t - 1][leaps]
        seen[~leaps] = times[t]
    return held


def algorithm_2(curve: Array, lines: Array, times: Array) -> list[tuple[int, int, int, float]]:
    """Return the key frames of Algorithm 2 with a line that moves, as (frame, found at, confirmed at, time).

    Early confirmation; a last key frame whose maximum never came is left out.
    """
    ceiling = floor = lines[0]
    moving, falling, at_floor, awaiting = bool(curve[0] > lines[0]), False, False, False
    run, candidate, found = 0, -1, 0
    keys: list[tuple[int, int, int, float]] = []
    for t in range(1, len(curve)):
        value, last, line, before = curve[t], curve[t - 1], lines[t], ceiling
        if value > ceiling:
            ceiling, floor = value, max(value - line, line)
        elif value < floor:
            floor = max(value, line)
            ceiling = min(value + line, ceiling)
        if at_floor and falling and value > last and (candidate < 0 or last < curve[candidate]):
            candidate, found = run, t
        crossed = bool(value > line) != moving
        awaiting = awaiting and value >= last and not crossed
        if crossed:
            moving, candidate = not moving, -1
            keys.append((t, t, t, float(times[t])))
        elif candidate >= 0 and value >= before:
            keys.append((candidate, found, t, float(times[candidate])))
            candidate, awaiting = -1, True
        if value != last:
            falling, at_floor, run = value < last, moving and value == floor, t
        at_floor = at_floor and not crossed
    return keys[:-1] if awaiting else keys


def filtered(poses: Array, dt: Array) -> Array:
    """Return the poses behind a first-order low-pass filter, exact for straight lines between them."""
    result = poses.copy()
    for t in range(1, len(poses)):
        late, kept = (
            kernels.SMOOTHING * (poses[t] - poses[t - 1]) / dt[t],
            np.exp(-dt[t] / kernels.SMOOTHING),
        )
        # A line is followed at a distance, `late`; deviations from it fade.
        result[t] = poses[t] - late + kept * (result[t - 1] - (poses[t - 1] - late))
    return result


def taken_frames(times: Array) -> NDArray[np.int64]:
    """Return the processed frames, about 30 Hz; the others are skipped."""
    taken = [0]
    for t in range(1, len(times)):
        if times[t] - times[taken[-1]] >= kernels.SPACING - MARGIN:
            taken.append(t)
    return np.array(taken)


def joint_speeds(poses: Array, times: Array) -> Array:
    """Return (n, J) m/s, over about a tenth of a second, from kept poses."""
    speeds, quanta = np.zeros(poses.shape[:2]), float(kernels.PER_QUANTUM)
    kept = np.rint(poses * quanta) / quanta
    for t in range(1, len(poses)):
        old = np.flatnonzero(times[:t] <= times[t] - kernels.SPEED_WINDOW + MARGIN)
        past = old[-1] if len(old) else 0
        speeds[t] = np.linalg.norm(poses[t] - kept[past], axis=1) / (times[t] - times[past])
    return speeds


def usual_speeds(speed: Array, dt: Array) -> Array:
    """Return V at each frame, m/s."""
    usual = np.empty(len(speed))
    squares, weight = kernels.PRIOR_SPEED**2, 1.0
    for t in range(len(speed)):
        left = np.exp2(-dt[t] / kernels.SCALES_HALF_LIFE)
        squares, weight = squares * left + speed[t] ** 2 * dt[t], weight * left + dt[t]
        usual[t] = max(np.sqrt(squares / weight), kernels.LEAST_USUAL_SPEED)
    return usual


def steadiness(lingers: NDArray[np.bool_], dt: Array) -> Array:
    """Return g at each frame: 1 for a performer who lingers rarely, 0 for one who lingers often."""
    lingered, weight = kernels.PRIOR_LINGERED, 1.0
    shares = np.full(len(dt), lingered / weight)
    for t in range(1, len(dt)):
        left = np.exp2(-dt[t] / kernels.SCALES_HALF_LIFE)
        lingered, weight = lingered * left + dt[t] * lingers[t], weight * left + dt[t]
        shares[t] = lingered / weight
    return np.clip(
        (kernels.LINGERS_OFTEN - shares) / (kernels.LINGERS_OFTEN - kernels.LINGERS_LITTLE), 0.0, 1.0
    )


def slowness(own_time: float, steady: float) -> float:
    """Return the tempo that evidence is divided by: how slow a performer is, which counts twice if steady."""
    tempo = own_time / kernels.ORDINARY
    if tempo > 1.0:
        tempo **= 1.0 + steady
    return float(np.clip(tempo, kernels.QUICKEST, kernels.SLOWEST + kernels.STEADY_SLOWEST * steady))


def surroundings(motion: Motion) -> tuple[Array, Array]:
    """Return A at each frame, m, and the distance of each pose from the one in which the performer dwells, m."""
    poses, joints = motion.poses, motion.moving_joints
    extent, away = np.empty(len(poses)), np.zeros(len(poses))
    mean, rest_pose = poses[0].copy(), poses[0].copy()
    spread, weight, dwelt = kernels.PRIOR_EXTENT**2, 1.0, kernels.PRIOR_DWELT
    for t, pose in enumerate(poses):
        dt = motion.dt[t]
        if dt > 0.0:
            dwelling = dt / (1.0 + (motion.speed[t] / (kernels.SLOW * motion.usual[t])) ** 2)
            dwelt = dwelt * np.exp2(-dt / kernels.REST_POSE_HALF_LIFE) + dwelling
            left = np.exp2(-dt / kernels.SCALES_HALF_LIFE)
            spread = spread * left + ((pose - mean) ** 2).sum() / joints * dt
            weight = weight * left + dt
            mean += min(dt / kernels.MEAN_TIME, 1.0) * (pose - mean)
            rest_pose += dwelling / dwelt * (pose - rest_pose)
        extent[t] = max(np.sqrt(spread / weight), kernels.LEAST_EXTENT)
        away[t] = np.sqrt(((pose - rest_pose) ** 2).sum() / joints)
    return extent, away


def _sums(motion: Motion) -> list[Array]:
    """Return sums over the frames before each one: durations, poses, squares, log speeds, squares."""
    usual = np.concatenate([[kernels.SPEED_OFFSET], kernels.SPEED_OFFSET * motion.usual[:-1]])
    log_speeds = np.log(motion.speeds + usual[:, None])
    values = [np.ones(len(motion.dt)), motion.poses, motion.poses**2, log_speeds, log_speeds**2]
    weighted = [value * motion.dt.reshape(-1, *[1] * (value.ndim - 1)) for value in values]
    return [np.cumsum(np.concatenate([np.zeros_like(value[:1]), value]), axis=0) for value in weighted]
