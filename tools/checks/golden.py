"""The results of a version, written to files, so that two versions can be compared byte for byte.

    python -m checks.golden FOLDER OLD --part streams --part random
    python -m checks.golden --compare OLD NEW

The first form writes the results of the imported version for the recordings in a folder: events and the other results of
the public API. Each case is a file `OLD/PART/.../CASE.gz` with one line for an event or a value; its first line is a
digest of the input. Without `--part` all parts are written, see `PARTS`. The second form compares two such folders,
names the first different line of each case, and exits with 1 if anything differs. The program uses the public API, the
readers, the built-in performer and `checks.random_takes` only; the interpreter's path selects the version.

The folder has `labelled`, `moves`, `quality`, `holds` and others with recordings as `.npz`, `.amc` and further formats;
missing ones are left out.
"""

import argparse
import contextlib
import functools
import gzip
import hashlib
import itertools
import json
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from checks import random_takes
from mossar_adapters.files import read
from mossar_stream import (
    Event,
    Frames,
    MossarError,
    Moves,
    Performers,
    Segmenter,
    Settings,
    Skeleton,
    gait_of,
    joint_angles,
    ranges_of_motion,
    segment_recording,
    step_table,
    to_json,
)

LEVELS = ("posture", "motion", "cluster")
PRESETS = ("default", "paper", "game")
CHUNK = 64
READERS: dict[str, dict[str, Any]] = {
    "limbs": {"limbs": True},
    "repetitions": {"repetitions": True},
    "phase": {"repetitions": True, "phase": True},
    "steps": {"steps": True},
    "limbs-repetitions": {"limbs": True, "repetitions": True},
}
EVERYTHING = {"limbs": True, "repetitions": True, "phase": True, "steps": True}
_LIKELIHOOD = {"similarity": "likelihood"}
_PATH_KERNEL = {"similarity": "path_kernel"}
# Settings beyond presets and levels; each alone, and with the presets and levels that take them.
VARIANTS: tuple[dict[str, Any], ...] = (
    {"similarity": "evidence"},
    _LIKELIHOOD,
    {**_LIKELIHOOD, "location": "free", "refine": 0.3},
    {**_LIKELIHOOD, "location": "candidates", "refine": 0.5},
    {**_LIKELIHOOD, "tempo": True},
    {**_LIKELIHOOD, "tempo": True, "location": "free", "refine": 0.3, "pre_roll": 0.5, "post_roll": 0.5},
    {**_LIKELIHOOD, "features": {"positions": 1.0}},
    {**_LIKELIHOOD, "features": {"distances": 1.0}, "short_segment": 1.0},
    {**_LIKELIHOOD, "features": {"log_speed": 1.0}},
    {**_LIKELIHOOD, "features": {"positions": 0.2, "distances": 0.3, "log_speed": 0.5}, "rests": "keep"},
    {**_LIKELIHOOD, "variance_floor": {"positions": 0.01, "distances": 0.01, "log_speed": 0.5}},
    {**_PATH_KERNEL, "kernel_form": "damped"},
    {**_PATH_KERNEL, "kernel_form": "sum"},
    {**_PATH_KERNEL, "kernel_form": "normalised"},
    {**_PATH_KERNEL, "kernel_form": "normalised", "edges": 7, "layers": 3},
    {**_PATH_KERNEL, "kernel_form": "damped", "edges": 45, "layers": 2, "tempo": True},
    {"range": "running", "range_floor": 0.0},
    {"range": "decay", "range_half_life": 5.0},
    {"range": "fixed", "range_min": 0.05, "range_max": 2.0},
    {"range": "file"},
    {"smoothing": "moving_average", "smoothing_window": 5},
    {"smoothing": "one_euro"},
    {"smoothing": "one_euro", "one_euro_cutoff": 0.5, "one_euro_beta": 10.0, "rate_limit": 0.0},
    {"center": "centroid"},
    {"rate_limit": 0.0},
    {"rate_limit": 12.0},
    {"window": 0.05, "sig_threshold": 0.01, "noise_margin": 0.0},
    {"window": 1.0, "sig_threshold": 0.1, "noise_margin": 5.0},
    {"rests": "merge"},
    {"rests": "keep"},
    {"remerge_window": 3, "remerge_seconds": 0.5},
    {"remerge_window": 60, "remerge_seconds": 8.0},
    {"max_gap": 0.0, "max_speed": 3.0},
    {"rest_seconds": 1.0},
    {"level": 0.2},
    {"level": 2.5},
    {"max_key_frames": 5},
)
# For readers: settings that only they make use of.
READER_VARIANTS: tuple[dict[str, Any], ...] = (
    {**EVERYTHING, "follow_every": 0.0},
    {**EVERYTHING, "up": "z", "step_sensitivity": 3.0},
    {**EVERYTHING, "up": "-x", "center": "centroid"},
    {**EVERYTHING, "rate_limit": 0.0, "smoothing": "one_euro"},
    {**EVERYTHING, "similarity": "path_kernel"},
    {**EVERYTHING, "preset": "paper"},
)
POOLS: tuple[dict[str, Any], ...] = (
    {},
    EVERYTHING,
    {"level": "cluster"},
    {"preset": "paper", "limbs": True},
)
# Joints of the recordings of exercises, which their files do not name.
EXERCISE_JOINTS = (
    "waist spine chest neck head head_tip left_collar left_shoulder left_elbow left_wrist right_collar right_shoulder "
    "right_elbow right_wrist left_hip left_knee left_ankle left_toes right_hip right_knee right_ankle right_toes"
)
EXERCISE_PARENTS = (-1, 0, 1, 2, 3, 4, 3, 6, 7, 8, 3, 10, 11, 12, 0, 14, 15, 16, 0, 18, 19, 20)

Lines = list[str]
Case = tuple[str, Callable[[], Lines]]


class Given(NamedTuple):
    """A recording: its name, (n, J, 3) m, (n,) s, joints, rate in Hz, and the frames of its cuts."""

    name: str
    positions: NDArray[Any]
    times: NDArray[np.float64]
    skeleton: Skeleton
    fps: float | None
    cuts: tuple[int, ...] = ()


class Options(NamedTuple):
    """Options: the folder of data, the number of random takes, and the first seed of them."""

    folder: Path
    takes: int
    seed: int


def exact(value: Any) -> Any:
    """Return a value as JSON has it, with each number to its last bit, arrays as their bytes' digest and first numbers."""
    if isinstance(value, np.ndarray):
        numbers = np.ascontiguousarray(value)
        digest = hashlib.sha256(numbers.tobytes()).hexdigest()[:16]
        return {
            "dtype": str(value.dtype),
            "shape": value.shape,
            "digest": digest,
            "first": exact(numbers.ravel()[:6].tolist()),
        }
    if isinstance(value, float | np.floating):
        return repr(float(value))
    if isinstance(value, np.integer | np.bool_):
        return value.item()
    if isinstance(value, msgspec.Struct):
        return {name: exact(getattr(value, name)) for name in value.__struct_fields__}
    if isinstance(value, Mapping):
        return {str(name): exact(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [exact(one) for one in value]
    return value


def line(label: str, value: Any) -> str:
    """Return a value with its label."""
    return f"{label}: {json.dumps(exact(value))}"


def refused(label: str, error: Exception) -> str:
    """Return the line of a refusal."""
    return f"{label}: refused: {type(error).__name__}: {error}"


def events_of(events: Iterable[Event]) -> Lines:
    """Return the lines of events."""
    return [to_json(event).decode() for event in events]


def digest(*arrays: NDArray[Any]) -> str:
    """Return the line with the digest of the input."""
    whole = hashlib.sha256()
    for array in arrays:
        whole.update(f"{array.dtype} {array.shape}".encode() + np.ascontiguousarray(array).tobytes())
    return f"given: {whole.hexdigest()}"


def recorded_as_arrays(path: Path) -> Given:
    """Return a recording of a `.npz` file."""
    content = np.load(path)
    fps = float(content["fps"])
    skeleton = Skeleton(tuple(map(str, content["joint_names"])), tuple(map(int, content["parents"])))
    positions = np.ascontiguousarray(content["positions"], np.float32)
    return Given(path.stem, positions, np.arange(len(positions)) / fps, skeleton, fps)


def read_by_adapters(path: Path, name: str, **options: Any) -> Given:
    """Return a recording of any format."""
    take = read(path, **options)
    return Given(name, take.positions, np.asarray(take.times, np.float64), take.skeleton, take.fps)


def labelled(folder: Path) -> Iterator[Given]:
    """Yield the recordings with cuts."""
    for path in sorted((folder / "labelled").rglob("*.json")):
        label = json.loads(path.read_text())
        file = path.parent / label["recording"]
        if file.suffix == ".npz":
            given = recorded_as_arrays(file)
        else:
            given = read_by_adapters(file, path.stem, skeleton=str(path.parent / label["skeleton"]))
        kind = path.parent.name if path.parent.name != "labelled" else "medleys"
        cuts = tuple(cut[1] for cut in label["cuts"])
        yield given._replace(name=f"{kind}/{path.stem}", cuts=cuts)
    for path in sorted((folder / "holds").glob("*.npz")):
        yield recorded_as_arrays(path)._replace(name=f"holds/{path.stem}")


def some(given: Iterable[Given], every: int) -> Iterator[Given]:
    """Yield every so-manieth recording of each set, and the first one of each."""
    seen = Counter[str]()
    for one in given:
        kind = one.name.split("/")[0]
        if seen[kind] % every == 0:
            yield one
        seen[kind] += 1


def moves_out_of(given: Given, *, mirrored: bool = True) -> Moves:
    """Return moves and a pose that are parts of a recording: those between its cuts, or its thirds."""
    count = len(given.positions)
    places = [cut for cut in given.cuts if 10 < cut < count][:6] or [count // 4, count // 2, 3 * count // 4]
    moves = Moves(given.skeleton)
    names = ("left_a", "left_b", "c", "left_a", "d")
    for name, (begin, end) in zip(names, itertools.pairwise([0, *places]), strict=False):
        try:
            moves.add(name, given.positions[begin:end], given.fps or 30.0)
        except MossarError:
            continue
    middle = given.positions[places[0] // 2]
    with contextlib.suppress(MossarError):
        moves.add_pose("still", middle, hold=0.2)
        moves.add_pose("later", given.positions[places[-1] :], given.fps or 30.0, hold=0.5)
    for name in moves.names if mirrored else ():
        try:
            moves.set_rule(name, mirrored=True, strict=0.4)
        except MossarError:
            continue
    return moves


def without_feet(given: Given, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings without steps if a skeleton has no feet."""
    chosen = dict(settings)
    if chosen.get("steps"):
        try:
            Segmenter(given.skeleton, Settings(steps=True))
        except MossarError:
            del chosen["steps"]
    return chosen


def streamed(
    given: Given,
    settings: Settings,
    moves: Moves | None = None,
    size: int = CHUNK,
    states: int = 0,
    *,
    follow: bool = False,
    with_fps: bool = True,
) -> Lines:
    """Return the events of a stream in chunks of a size, and its other numbers after every so-manieth chunk.

    Args:
        given: The recording.
        settings: In force.
        moves: That are recognised; their explanations are in the lines, too.
        size: Frames of a chunk.
        states: Number of chunks between written states; 0 for none.
        follow: Whether the moves are followed.
        with_fps: Whether the nominal rate is given.
    """
    found = [digest(given.positions, given.times)]
    if moves is not None:
        moves.explained = lambda explanation: found.append(line("explained", explanation))
    segmenter = Segmenter(
        given.skeleton, settings, fps=given.fps if with_fps else None, moves=moves, follow=follow
    )
    for number, begin in enumerate(range(0, len(given.times), size)):
        place: slice | int = begin if size == 1 else slice(begin, begin + size)
        found += events_of(segmenter.push(given.positions[place], given.times[place]))
        if states and number % states == 0:
            found += states_of(segmenter)
    found += states_of(segmenter)
    found += events_of(segmenter.end_take("over"))
    return [*found, line("stats", segmenter.stats)]


def states_of(segmenter: Segmenter) -> Lines:
    """Return the state of a segmenter between two calls."""
    return [
        line("state", segmenter.state),
        line("limbs", segmenter.limb_states),
        line("following", segmenter.following),
        line("repeats", [segmenter.repetitions, segmenter.phase]),
        line("counts", segmenter.counts),
    ]


def as_recording(
    given: Given,
    settings: Settings,
    moves: Moves | None = None,
    *,
    follow: bool = False,
    curves: bool = False,
) -> Lines:
    """Return the results of a whole recording, and the levels of its hierarchy."""
    result = segment_recording(
        given.positions, given.fps, given.skeleton, settings, times=given.times, curves=curves, moves=moves,
        follow=follow,
    )  # fmt: skip
    found = [digest(given.positions, given.times)]
    for name in ("key_frames", "hierarchy", "curves", "moves", "followed", "poses", "repetitions", "steps"):
        found += [line(name, one) for one in getattr(result, name)]
    whole = {"": result, **result.limbs}
    for name, own in whole.items():
        if name:
            found += [line(f"{name} key_frames", one) for one in (*own.key_frames, *own.repetitions)]
        found += levels_of(own, name)
    return found


def levels_of(result: Any, name: str) -> Lines:
    """Return the segmentation of a recording at levels and with numbers of key frames."""
    found = []
    strengths = sorted(key.strength for key in result.key_frames if np.isfinite(key.strength))
    levels = [result.settings.level, 0.0, *strengths[:: max(1, len(strengths) // 3)][:4]]
    ways: list[tuple[str, dict[str, Any]]] = [(f"level {level!r}", {"level": level}) for level in levels]
    ways += [(f"count {count}", {"count": count}) for count in (0, 3, 10)]
    for label, way in ways:
        try:
            segmentation = result.at(**way)
        except (MossarError, ValueError) as error:
            found.append(refused(label, error))
            continue
        found += [line(f"{name} {label} key frame", one) for one in segmentation.key_frames]
        found += [line(f"{name} {label} segment", one) for one in segmentation.segments]
    return found


def label_of(settings: Mapping[str, Any]) -> str:
    """Return settings as a part of a file's name."""
    parts = []
    for name, value in settings.items():
        text = ",".join(f"{k}:{v}" for k, v in value.items()) if isinstance(value, dict) else str(value)
        parts.append(f"{name}={text}".replace("/", "_"))
    return " ".join(parts) or "usual"


def built(settings: Mapping[str, Any]) -> Settings:
    """Return settings, of which `preset` is one."""
    values = dict(settings)
    return Settings.build(values.pop("preset", "default"), values)


def stream_case(
    given: Given,
    settings: Mapping[str, Any],
    moves: Callable[[], Moves] | None = None,
    label: str = "",
    **how: Any,
) -> Case:
    """Return the case of a stream."""

    def work() -> Lines:
        return streamed(
            given, built(without_feet(given, settings)), None if moves is None else moves(), **how
        )

    return f"{given.name}/{label}{label_of(settings)}", work


def recording_case(
    given: Given,
    settings: Mapping[str, Any],
    moves: Callable[[], Moves] | None = None,
    label: str = "",
    **how: Any,
) -> Case:
    """Return the case of a recording."""

    def work() -> Lines:
        return as_recording(
            given, built(without_feet(given, settings)), None if moves is None else moves(), **how
        )

    return f"{given.name}/{label}{label_of(settings)}", work


def streams(options: Options) -> Iterator[Case]:
    """Labelled recordings, streamed in chunks, with each preset at each level."""
    for given in labelled(options.folder):
        for preset, level in itertools.product(PRESETS, LEVELS):
            yield stream_case(given, {"preset": preset, "level": level})


def readers(options: Options) -> Iterator[Case]:
    """The same with limbs, moves, following, poses, repetitions, phase and steps all at once, and on some each alone."""
    for given in labelled(options.folder):
        moves = functools.partial(moves_out_of, given)
        for level in LEVELS:
            yield stream_case(given, {"level": level, **EVERYTHING}, moves, "all ", follow=True)
    for given in some(labelled(options.folder), 6):
        moves = functools.partial(moves_out_of, given)
        for name, settings in READERS.items():
            for level in LEVELS:
                yield stream_case(given, {"level": level, **settings}, None, f"{name} ")
        for level in LEVELS:
            yield stream_case(given, {"level": level}, moves, "moves ")
            yield stream_case(given, {"level": level}, moves, "following ", follow=True)
        for preset in PRESETS[1:]:
            yield stream_case(given, {"preset": preset, **EVERYTHING}, moves, "all ", follow=True)


def presets(options: Options) -> Iterator[Case]:
    """Every second labelled recording with everything at once, with the other presets at each level."""
    for given in some(labelled(options.folder), 2):
        moves = functools.partial(moves_out_of, given)
        for preset, level in itertools.product(PRESETS[1:], LEVELS):
            settings = {"preset": preset, "level": level, **EVERYTHING}
            yield stream_case(given, settings, moves, "all ", follow=True)


def variants(options: Options) -> Iterator[Case]:
    """Some of the labelled recordings, streamed and whole, with other settings."""
    for given in some(labelled(options.folder), 10):
        short = given._replace(positions=given.positions[:3000], times=given.times[:3000])
        for settings in VARIANTS:
            if settings.get("range") != "file":
                yield stream_case(short, settings, label="stream ")
            yield recording_case(short, settings, label="recording ")
        for settings in READER_VARIANTS:
            yield stream_case(short, settings, functools.partial(moves_out_of, short), "stream ", follow=True)


def single(options: Options) -> Iterator[Case]:
    """Some of the labelled recordings frame by frame, with the numbers that are no events after each eighth frame."""
    for given in some(labelled(options.folder), 5):
        short = given._replace(positions=given.positions[:2000], times=given.times[:2000])
        moves = functools.partial(moves_out_of, short)
        for level in LEVELS:
            yield stream_case(short, {"level": level}, size=1, states=8)
        yield stream_case(short, EVERYTHING, moves, "all ", size=1, states=8, follow=True)
        yield stream_case(short, {"preset": "paper"}, size=1, states=8)
        yield stream_case(short, {"preset": "game"}, label="no rate ", size=1, with_fps=False)


def recordings(options: Options) -> Iterator[Case]:
    """Labelled recordings as a whole: key frames, strengths, hierarchy and levels; on some everything else, too."""
    for given in labelled(options.folder):
        for level in LEVELS:
            yield recording_case(given, {"level": level})
        yield recording_case(given, {"range": "file"})
    for given in some(labelled(options.folder), 6):
        short = given._replace(positions=given.positions[:3000], times=given.times[:3000])
        moves = functools.partial(moves_out_of, short)
        for level in LEVELS:
            yield recording_case(
                short, {"level": level, **EVERYTHING}, moves, "all ", follow=True, curves=True
            )
        yield recording_case(short, {"preset": "paper"}, label="paper ", curves=True)
        yield recording_case(short, {"range": "file", "limbs": True, "level": "cluster"}, curves=True)


def commands(options: Options) -> Iterator[Case]:
    """Moves on command, with two examples of each move by the same player."""
    folder = options.folder / "moves" / "kinect"
    for number, path in enumerate(sorted((folder / "sessions").glob("*.npz"))):
        given = recorded_as_arrays(path)
        shown = np.load(folder / "samples" / path.name)

        def moves(
            given: Given = given, shown: Any = shown, *, facing: Any = "any", mirrored: bool = False
        ) -> Moves:
            made = Moves(given.skeleton)
            for name in shown.files:
                made.add(name.rsplit("_", 1)[0], shown[name], fps=given.fps or 30.0)
            made.facing = facing
            for name in made.names if mirrored else ():
                made.set_rule(name, mirrored=True, strict=0.6, again=1.0)
            made.add_pose("begin", given.positions[200], hold=0.3)
            return made

        short = given._replace(positions=given.positions[:2500], times=given.times[:2500])
        yield stream_case(given, {}, moves, "moves ")
        yield stream_case(short, EVERYTHING, moves, "all ", follow=True)
        for level in LEVELS:
            yield stream_case(given, {"level": level, "limbs": True, "repetitions": True, "steps": True})
        if number % 3 == 0:
            yield stream_case(short, {"preset": "game"}, moves, "single ", size=1, states=16, follow=True)
            yield stream_case(short, {"preset": "paper"}, moves, "paper ")
            mirrored = functools.partial(moves, facing="as_shown", mirrored=True)
            yield stream_case(short, {}, mirrored, "mirrored ", follow=True)
            yield recording_case(short, {}, moves, "recording ", follow=True)


def quality(options: Options) -> Iterator[Case]:
    """Right and wrong repetitions of exercises, followed with an example of one's own and with those of others."""
    skeleton = Skeleton(tuple(EXERCISE_JOINTS.split()), EXERCISE_PARENTS)
    people = [np.load(path) for path in sorted((options.folder / "quality" / "ui_prmd").glob("s*.npz"))]
    for person, content in enumerate(people):
        others = people[(person + 1) % len(people)]
        for exercise in sorted({name.split("_")[0] for name in content.files}):
            right, wrong = (
                [name for name in content.files if name.startswith(f"{exercise}_{kind}")]
                for kind in ("right", "wrong")
            )
            foreign = [name for name in others.files if name.startswith(f"{exercise}_right")][:2]

            def moves(
                shown: Sequence[Any] = (content[right[0]],),
                skeleton: Skeleton = skeleton,
                *,
                mirrored: bool = False,
            ) -> Moves:
                made = Moves(skeleton)
                for positions in shown:
                    made.add("it", positions, fps=30.0)
                if mirrored:
                    made.set_rule("it", mirrored=True)
                return made

            def theirs(
                shown: Sequence[Any] = tuple(others[name] for name in foreign), make: Any = moves
            ) -> Moves:
                return make(shown, mirrored=True)  # type: ignore[no-any-return]

            for kind, names in (("right", right[1:]), ("wrong", wrong)):
                positions = np.concatenate(
                    [np.ascontiguousarray(content[name], np.float32) for name in names]
                )
                times = np.arange(len(positions)) / 30.0
                given = Given(f"s{person}/{exercise} {kind}", positions, times, skeleton, 30.0)
                yield stream_case(given, {}, moves, "own ", states=1, follow=True)
                yield stream_case(given, {}, theirs, "others ", follow=True)
                yield stream_case(given, {"repetitions": True, "limbs": True, "phase": True})
                if exercise in ("m01", "m06"):
                    yield stream_case(
                        given, {"follow_every": 0.0}, moves, "single ", size=1, states=1, follow=True
                    )
                    yield recording_case(given, {}, moves, "recording ", follow=True)


def formats(options: Options) -> Iterator[Case]:
    """Recordings of other formats and bodies, and poses that an image's edges have stretched, with everything on."""
    root = options.folder
    paths = [
        p for name in ("formats", "public_cases") for p in sorted((root / name).rglob("*")) if p.is_file()
    ]
    for path in paths:
        name = str(path.relative_to(root)).replace("/", " ")
        skeleton = path.with_name("skeleton.asf")
        more = {"skeleton": str(skeleton)} if path.suffix == ".amc" and skeleton.exists() else {}

        def work(path: Path = path, more: dict[str, str] = more) -> Lines:
            given = read_by_adapters(path, path.name, allow_2d=True, **more)
            given = given._replace(positions=given.positions[:4000], times=given.times[:4000])
            found = streamed(given, built(without_feet(given, EVERYTHING)), moves_out_of(given), follow=True)
            found += streamed(given, built({"level": "cluster", "limbs": True}), with_fps=False)
            return [*found, *as_recording(given, built({"level": "posture", "range": "file", "limbs": True}))]

        if path.suffix.lower() in (".bvh", ".c3d", ".trc", ".csv", ".amc", ".json", ".jsonl", ".osc"):
            yield f"files/{name}", work
    for path in sorted((root / "stretched_repcount").glob("*.npz")):
        given = recorded_as_arrays(path)
        given = given._replace(name=f"stretched/{path.stem}")
        yield stream_case(given, EVERYTHING, functools.partial(moves_out_of, given), "all ", follow=True)
        yield stream_case(given, {"level": "posture", "repetitions": True})


def inputs(options: Options) -> Iterator[Case]:
    """Frames as other types, with confidence, far from the origin, with holes, as one joint, and numbered."""
    for given in some(labelled(options.folder), 12):
        base = given._replace(positions=given.positions[:1000], times=given.times[:1000])
        noise = np.random.default_rng(3)
        holes = np.array(base.positions)
        holes[noise.random(holes.shape[:2]) < 0.05] = np.nan
        holes[300:360, 0] = np.nan
        ways: dict[str, Given] = {
            "double": base._replace(positions=base.positions.astype(np.float64)),
            "half": base._replace(positions=base.positions.astype(np.float16)),
            "whole": base._replace(positions=np.round(base.positions * 3).astype(np.int16)),
            "strided": base._replace(positions=np.asfortranarray(base.positions)),
            "far": base._replace(positions=np.add(base.positions, (4e4, -2e3, 7e3), dtype=np.float64)),
            "holes": base._replace(positions=holes),
            "late": base._replace(times=base.times + 1.7e9),
            "unsteady": base._replace(times=base.times + noise.normal(0, 0.01, len(base.times))),
            "slow": base._replace(times=base.times * 40),
            "rootless": base._replace(skeleton=Skeleton(base.skeleton.names)),
            "unnamed": base._replace(
                skeleton=Skeleton(tuple(f"m{k}" for k in range(len(base.skeleton))), (), -1)
            ),
            "pair": base._replace(
                positions=base.positions[:, :2].copy(), skeleton=Skeleton(("a", "b"), (-1, 0))
            ),
        }
        for name, other in ways.items():
            for settings in ({}, {"level": "posture"}, {"level": "cluster", **EVERYTHING}):
                yield stream_case(other, settings, label=f"{name} ")
            yield stream_case(other, EVERYTHING, label=f"{name} single ", size=1)
            yield recording_case(other, {"limbs": True}, label=f"{name} recording ")
        yield f"{base.name}/confidence", functools.partial(_with_confidence, base)


def _with_confidence(given: Given) -> Lines:
    """Return the events of frames with a confidence, and numbers with gaps."""
    segmenter = Segmenter(given.skeleton, built(without_feet(given, EVERYTHING)), fps=given.fps)
    found, noise = [], np.random.default_rng(5)
    for begin in range(0, len(given.times), 50):
        positions, moments = given.positions[begin : begin + 50], given.times[begin : begin + 50]
        sure = (noise.random(positions.shape[:2]) > 0.1).astype(np.float32)
        found += events_of(segmenter.push(Frames(positions, moments, sure, first_frame=3 * begin + 7)))
    return found + events_of(segmenter.end_take())


def pools(options: Options) -> Iterator[Case]:
    """Performers together, who come and go, with changes, snapshots and moves."""
    kinds: dict[str, list[Given]] = {}
    for given in labelled(options.folder):
        kinds.setdefault(given.name.split("/")[0], []).append(given)
    for kind, takes in kinds.items():
        for k, settings in enumerate(POOLS):
            for first in range(0, min(len(takes), 24), 6):

                def work(
                    some: Sequence[Given] = takes[first : first + 6],
                    settings: Mapping[str, Any] = settings,
                    seed: int = 100 * first + k,
                ) -> Lines:
                    return together(some, built(without_feet(some[0], settings)), seed)

                yield f"{kind}/{first} {label_of(settings)}", work


def together(takes: Sequence[Given], settings: Settings, seed: int) -> Lines:
    """Return the events of a pool in which recordings of one skeleton are played, with changes at times that a seed gives."""
    rng = np.random.default_rng(seed)
    moves = moves_out_of(takes[0]) if seed % 2 else None
    pool = Performers(settings, moves=moves, follow=moves is not None, most=max(1, len(takes) - 1))
    names = [f"p{k}" for k in range(len(takes))]
    found = []
    for name, take in zip(names, takes, strict=True):
        found += events_of(pool.announce(name, take.skeleton, take.fps))
    shortest = min(1200, *(len(take.times) for take in takes))
    begin, turn = 0, 0
    while begin < shortest:
        end = min(shortest, begin + int(rng.choice([1, 5, 10, 64])))
        chosen = [k for k, name in enumerate(names) if name in pool and rng.random() < 0.9]
        if chosen:
            frames = np.stack([takes[k].positions[begin:end] for k in chosen])
            found += events_of(pool.push_many([names[k] for k in chosen], frames, takes[0].times[begin:end]))
        found += _pool_turn(pool, takes, turn, rng)
        begin, turn = end, turn + 1
    return found + events_of(pool.end_takes("over"))


def _pool_turn(pool: Performers, takes: Sequence[Given], turn: int, rng: np.random.Generator) -> Lines:
    """Change something in a pool now and then."""
    what, who = turn % 24, f"p{rng.integers(len(takes))}"
    found = []
    try:
        if what == 5:
            found = events_of(pool.announce(who, takes[0].skeleton, takes[0].fps))
        elif what == 9:
            pool.level = float(rng.choice([0.2, 0.6, 1.5]))
        elif what == 13:
            pool.restore(pool.snapshot(), pool.lasting())
        elif what == 17 and who in pool:
            found = events_of(pool.change(who, limbs=bool(turn % 2)))
        elif what == 20 and who in pool:
            found = events_of(pool.reset(who))
        elif what == 23 and who in pool:
            found = events_of(pool.remove(who, "left"))
    except (MossarError, ValueError) as error:
        found = [refused(f"turn {turn}", error)]
    return found


def numbers(options: Options) -> Iterator[Case]:
    """Results of the public API besides events: comparisons, costs, kinds, oddities, angles, gait, discovered moves."""
    for given in some(labelled(options.folder), 8):
        yield f"{given.name}/comparison", functools.partial(comparisons, given)
        yield f"{given.name}/angles", functools.partial(angles, given)
        yield f"{given.name}/snapshots", functools.partial(continued, given)
        yield f"{given.name}/moves", lambda given=given: compared(moves_out_of(given))  # type: ignore[misc]
        if len(given.times) < 5000:
            yield f"{given.name}/discovered", functools.partial(discovered, given)
    samples = [
        *(options.folder / "moves").glob("kinect/samples/*.npz"),
        *(options.folder / "moves").glob("machete/*.npz"),
    ]
    joints = {}
    for path in sorted((options.folder / "moves").glob("kinect/sessions/*.npz")):
        skeleton = recorded_as_arrays(path).skeleton
        joints[len(skeleton)] = skeleton
    for path in sorted(samples):

        def work(path: Path = path, joints: Mapping[int, Skeleton] = joints) -> Lines:
            content = np.load(path)
            made = Moves(joints[content[content.files[0]].shape[1]])
            for name in content.files[:40]:
                made.add(name.rsplit("_", 1)[0], content[name], fps=30.0)
            return compared(made)

        if np.load(path)[np.load(path).files[0]].ndim == 3:
            yield f"samples/{path.parent.parent.name} {path.parent.name} {path.stem}", work


def comparisons(given: Given) -> Lines:
    """Return the strengths between neighbouring parts of a recording, by each measure."""
    from checks.paper.comparison import Comparison

    found = []
    poses = np.ascontiguousarray(given.positions[:2000] - given.positions[:2000, :1], np.float32)
    for settings in VARIANTS[:16]:
        if {"tempo", "location", "rests"} & {*settings}:
            continue
        comparison = Comparison(poses, given.times[:2000], built(settings), given.skeleton.root, 0.1, 4)
        label = label_of(settings)
        found.append(line(label, comparison.starts))
        found += [line(label, one) for one in comparison.between(0, comparison.pieces, 20).tolist()]
    return found


def angles(given: Given) -> Lines:
    """Return angles, their ranges in repetitions, and the gait."""
    settings = built(without_feet(given, {"repetitions": True, "steps": True}))
    result = segment_recording(given.positions, given.fps, given.skeleton, settings, times=given.times)
    found_angles = joint_angles(given.positions, given.skeleton)
    found = [line(name, angle) for name, angle in found_angles.items()]
    found += [line("range", one) for one in ranges_of_motion(found_angles, given.times, result.repetitions)]
    found += [line("step", one) for one in step_table(result.steps)]
    return [*found, line("gait", gait_of(result.steps))]


def continued(given: Given) -> Lines:
    """Return the events of a stream that goes on from a snapshot after each chunk, which are those of one without."""
    settings = built(without_feet(given, EVERYTHING))
    segmenter = Segmenter(given.skeleton, settings, fps=given.fps, moves=moves_out_of(given), follow=True)
    found = []
    for begin in range(0, min(len(given.times), 1500), 40):
        end = begin + 40
        found += events_of(segmenter.push(given.positions[begin:end], given.times[begin:end]))
        segmenter = Segmenter.restore(segmenter.snapshot())
    return found + events_of(segmenter.end_take())


def compared(moves: Moves) -> Lines:
    """Return the costs between the examples of moves, and their oddities."""
    found = [line("file", hashlib.sha256(moves.to_json()).hexdigest()), line("kinds", moves.kinds())]
    found += [line("oddity", moves.oddity(place)) for place in range(len(moves))]
    found += [line("image", one) for one in moves.examples_and_images("z")]
    for example in moves.examples[:12]:
        positions = np.asarray(example.positions, np.float64).reshape(-1, len(moves.skeleton), 3) / 1000.0
        try:
            found.append(line("costs", moves.costs(positions, example.fps)))
        except (MossarError, ValueError) as error:
            found.append(refused("costs", error))
    return found


def discovered(given: Given) -> Lines:
    """Return the kinds of movements that are found in a recording."""
    from mossar_adapters.files.loaded import LoadedRecording
    from mossar_tools.discovering import discover

    whole = LoadedRecording(given.name, given.skeleton, given.fps, given.positions, given.times)
    found = []
    for level in LEVELS:
        kinds, left_out = discover(whole, Settings(level=level))  # type: ignore[arg-type]
        found.append(line(level, left_out))
        found += [line(level, [[part.start, part.end, part.fps] for part in kind]) for kind in kinds]
    return found


def random_cases(options: Options) -> Iterator[Case]:
    """Takes of `checks.random_takes`: in chunks, at random with snapshots, in a pool, as recordings."""
    for seed in range(options.seed, options.seed + options.takes):
        yield f"{seed // 100:03d}/{seed}", functools.partial(random_case, seed)


def random_case(seed: int) -> Lines:
    """Return the results of the take of a seed; ways with the same events have one line that says so."""
    take = random_takes.random_take(seed, 6.0)
    expected = [text.decode() for text in random_takes.alone(take, CHUNK, seed)]
    found = [digest(take.positions, take.times), line("settings", take.settings), *expected]
    ways: dict[str, Callable[[], list[bytes]]] = {
        "random chunks, snapshots": lambda: random_takes.alone(take, 0, seed, snapshots=0.1),
        "a pool": lambda: random_takes.pooled(take, 32, seed),
    }
    if seed % 5 == 0:
        ways["single frames"] = lambda: random_takes.alone(take, 1, seed)
    for name, way in ways.items():
        own = [text.decode() for text in way()]
        found += [f"{name}: the same"] if own == expected else [f"{name}: others", *own]
    return found + random_takes.recorded(take, singly=seed % 5 == 0)


PARTS: dict[str, Callable[[Options], Iterator[Case]]] = {
    "streams": streams,
    "readers": readers,
    "presets": presets,
    "variants": variants,
    "single": single,
    "recordings": recordings,
    "commands": commands,
    "quality": quality,
    "formats": formats,
    "inputs": inputs,
    "pools": pools,
    "numbers": numbers,
    "random": random_cases,
}


def write(part: str, options: Options, out: Path) -> None:
    """Write the cases of a part, and print their number and the time."""
    begun, count, lines, refusals = time.perf_counter(), 0, 0, 0
    for name, work in PARTS[part](options):
        try:
            found = work()
        except (MossarError, ValueError, OSError, ArithmeticError, LookupError, TypeError) as error:
            found = [refused("case", error)]
            refusals += 1
        path = out / part / f"{name}.gz"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(gzip.compress("".join(f"{one}\n" for one in found).encode(), 3, mtime=0))
        count, lines = count + 1, lines + len(found)
        if count % 200 == 0:
            print(f"{part}: {count} cases, {time.perf_counter() - begun:.0f} s", flush=True)
    seconds = time.perf_counter() - begun
    print(f"{part}: {count} cases, {refusals} refused, {lines} lines, {seconds:.0f} s", flush=True)


def cases_in(folder: Path, parts: Sequence[str]) -> dict[str, Path]:
    """Return the files of cases by name."""
    paths = (path for part in parts for path in (folder / part).rglob("*.gz"))
    return {str(path.relative_to(folder)): path for path in sorted(paths)}


def compare(old: Path, new: Path, parts: Sequence[str], shown: int) -> bool:
    """Print the number of equal cases and the first different lines, and return whether all are; missing ones are different."""
    before, now = cases_in(old, parts), cases_in(new, parts)
    equal, groups = dict[str, Counter[str]](), Counter[str]()
    for name in sorted({*before, *now}):
        group = "/".join(name.split("/")[:2]) if not name.startswith("random") else "random"
        count = equal.setdefault(group, Counter())
        if name not in now or name not in before:
            count["only old" if name in before else "only new"] += 1
            continue
        one, other = before[name].read_bytes(), now[name].read_bytes()
        # The compression may differ between interpreters; the content counts.
        if one == other or (one := gzip.decompress(one)) == (other := gzip.decompress(other)):
            count["equal"] += 1
            continue
        count["different"] += 1
        groups[group] += 1
        if groups[group] <= shown:
            print(first_difference(name, one.decode().splitlines(), other.decode().splitlines()))
    for group, count in equal.items():
        print(f"{group}: " + ", ".join(f"{number} {kind}" for kind, number in count.items()))
    whole = sum(equal.values(), Counter())
    print("all: " + ", ".join(f"{number} {kind}" for kind, number in whole.items()))
    return bool(whole) and set(whole) == {"equal"}


def first_difference(name: str, old: Lines, new: Lines) -> str:
    """Return the first different line of a case, and the number of different lines."""
    pairs = list(itertools.zip_longest(old, new))
    place = next(k for k, (one, other) in enumerate(pairs) if one != other)
    many = sum(one != other for one, other in pairs)
    one, other = ("(nothing)" if text is None else _around(text, pairs[place]) for text in pairs[place])
    return f"{name}: line {place + 1}, {many} of {len(pairs)} differ\n  old {one}\n  new {other}"


def _around(text: str, pair: tuple[str | None, str | None]) -> str:
    """Return a line from a little before where two differ."""
    one, other = (each or "" for each in pair)
    at = next((k for k, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), 0)
    begin = 0 if at < 300 else at - 200
    return ("... " if begin else "") + text[begin : begin + 500]


def main() -> int:
    """Write or compare."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.golden", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("folders", nargs=2, type=Path, help="data and output, or with --compare old and new")
    parser.add_argument("--compare", action="store_true")
    parser.add_argument("--part", action="append", choices=PARTS, help="again for more; all without")
    parser.add_argument("--takes", type=int, default=2000, help="random takes")
    parser.add_argument("--seed", type=int, default=1, help="of the first random take")
    parser.add_argument("--shown", type=int, default=3, help="different cases that are shown of each group")
    given = parser.parse_args()
    parts = given.part or list(PARTS)
    warnings.simplefilter("ignore")
    np.seterr(all="ignore")
    one, other = given.folders
    if given.compare:
        return 0 if compare(one, other, parts, given.shown) else 1
    for part in parts:
        write(part, Options(one, given.takes, given.seed), other)
    return 0


if __name__ == "__main__":
    sys.exit(main())
