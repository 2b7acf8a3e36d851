"""Settings of a segmenter: one frozen record, validated once.

Fields that are None take their value from the bundle of the named level (`presets.py`); `Settings.resolved`
fills them in. The names are those of the command line's `--set name=value`.
"""

import difflib
from collections.abc import Mapping
from typing import Annotated, Any, Literal, get_args

import msgspec

from mossar_stream.errors import SettingsError
from mossar_stream.settings.feet import parse_feet
from mossar_stream.settings.limb_groups import parse_groups
from mossar_stream.settings.meta import document, metas_of, setting
from mossar_stream.settings.presets import BUNDLES, PRESETS, RANGE_FLOOR_SPEED, STRENGTHS

Smoothing = Literal["none", "moving_average", "one_euro"]
RangePolicy = Literal["running", "file", "fixed", "decay"]
Center = Literal["root", "centroid"]
SimilarityName = Literal["evidence", "likelihood", "path_kernel"]
KernelForm = Literal["damped", "sum", "normalised"]
Location = Literal["none", "free", "candidates"]
Rests = Literal["merge", "keep"]
Up = Literal["auto", "x", "y", "z", "-x", "-y", "-z"]
LevelName = Literal["posture", "motion", "cluster"]
LEVEL_NAMES: tuple[str, ...] = get_args(LevelName)


class Features(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Weights of the feature groups in the likelihood; each is shared equally by the group's dimensions.

    Args:
        positions: Weight of the positions relative to the centre.
        distances: Weight of the distances between joints.
        log_speed: Weight of the logarithms of the joints' speeds.
    """

    positions: float = 0.0
    distances: float = 0.0
    log_speed: float = 0.0


class VarianceFloor(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Floor on the variance of each feature group in the likelihood.

    Args:
        positions: m².
        distances: m².
        log_speed: log(m/s) squared.
    """

    positions: float = 0.001
    distances: float = 0.003
    log_speed: float = 0.1


class _NamedFields(msgspec.StructMeta):
    """Makes a record refuse an unknown field with a list of the known ones."""

    def __call__(self, *args: Any, **fields: Any) -> Any:
        if unknown := next((name for name in fields if name not in self.__struct_fields__), None):
            raise TypeError(_unknown(unknown))
        return super().__call__(*args, **fields)


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, metaclass=_NamedFields):
    """Everything that can be set on a segmenter.

    The methods are those of Paliyawan, Choensawat and Thawonmas, *Mossar: motion segmentation by using splitting and remerging
    strategies* (2018): equation 1 (`window`), Algorithms 1 and 2 (`sig_threshold`), Algorithm 3 (`level`, `max_key_frames`)
    and the path kernel (`edges`, `layers`). `Settings.build("paper")` has the paper's values.

    Args:
        FIELDS

    Raises:
        SettingsError: If a value is outside its legal range; the message names field, value and range.

    Example:
        >>> Settings(level="cluster").resolved().remerge_seconds
        4.4
    """

    rate_limit: Annotated[
        float | None,
        setting(
            "Highest rate at which frames are processed; frames between are counted and skipped. 0 processes all, as a `fixed` range does by default",
            "lower: fewer frames are processed, the others are skipped; 0 processes all",
            unit="Hz",
            low=0.0,
            high=1e4,
        ),
    ] = None
    window: Annotated[
        float | None,
        setting(
            "Trailing window of the velocity (equation 1; the paper's is 1 s)",
            "longer: a smoother velocity, fewer key frames, each later",
            unit="s",
            low=0.01,
            high=10.0,
        ),
    ] = None
    smoothing: Annotated[
        Smoothing,
        setting(
            "`none`, `moving_average` of the velocity (the paper's) or `one_euro` filter on the joints",
            "none, moving_average of the velocity (the paper's), one_euro filter on the joints",
        ),
    ] = "none"
    smoothing_window: Annotated[
        int,
        setting(
            "Length of the moving average (wSize)",
            "longer: smoother, later; for smoothing=moving_average",
            unit="frames",
            low=1,
            high=1000,
        ),
    ] = 1
    one_euro_cutoff: Annotated[
        float,
        setting(
            "Minimum cut-off frequency of the One-Euro filter",
            "smaller: less jitter, more lag; for smoothing=one_euro",
            unit="Hz",
            low=0.01,
            high=100.0,
        ),
    ] = 1.5
    one_euro_beta: Annotated[
        float,
        setting(
            "Speed coefficient of the One-Euro filter",
            "larger: less lag in quick moves; for smoothing=one_euro",
            unit="Hz per m/s",
            low=0.0,
            high=1000.0,
        ),
    ] = 2.0
    sig_threshold: Annotated[
        float,
        setting(
            "θ (sigThre)",
            "larger: fewer onsets, offsets and minima; small moves are missed",
            unit="of the range",
            low=0.0,
            high=1.0,
        ),
    ] = 0.05
    range: Annotated[
        RangePolicy,
        setting(
            "Source of the range for normalisation: the largest value so far (`running`), the whole recording (`file`, offline only), `fixed` bounds, or a `decay`-ing maximum",
            "running: the largest velocity so far; decay: forgets it slowly; fixed: range_min to range_max; file: offline",
        ),
    ] = "running"
    range_min: Annotated[
        float,
        setting(
            "Lower bound for `fixed`, as a path summed over the joints within the window",
            "for range=fixed: the summed path of all joints within the window that counts as 0",
            unit="m",
            low=0.0,
            high=1e6,
        ),
    ] = 0.0
    range_max: Annotated[
        float | None,
        setting(
            "Upper bound for `fixed`",
            "for range=fixed: the summed path that counts as 1; larger: fewer key frames",
            unit="m",
            low=0.0,
            high=1e6,
        ),
    ] = None
    range_half_life: Annotated[
        float,
        setting(
            "Half-life of the maximum for `decay`",
            "for range=decay; shorter: quiet moves count again sooner after a wild one",
            unit="s",
            low=0.1,
            high=1e6,
        ),
    ] = 300.0
    range_floor: Annotated[
        float | None,
        setting(
            "Least range for `running` and `decay`, over the window",
            "larger: small movements cause fewer key frames",
            unit="m per joint",
            low=0.0,
            high=1e3,
        ),
    ] = None
    noise_margin: Annotated[
        float,
        setting(
            "θ · range is at least this many times the velocity that the sensor's noise adds, for `running`, `decay` and `file`; 0 is off",
            "larger: a noisy sensor causes fewer key frames; 0 is off",
            low=0.0,
            high=100.0,
        ),
    ] = 1.5
    center: Annotated[
        Center,
        setting(
            "Body centre that positions are relative to: the skeleton's `root`, or the `centroid`",
            "root: positions relative to the root joint; centroid: to the mean of the joints",
        ),
    ] = "root"
    similarity: Annotated[
        SimilarityName | None,
        setting(
            "Measure that compares neighbouring segments: `evidence`, `likelihood` or `path_kernel` (the paper's)",
            "evidence: odds of a change, a stop, a rest; likelihood: whether one pose distribution explains both sides; path_kernel: the paper's",
        ),
    ] = None
    features: Annotated[
        Features | None,
        setting(
            "Weights of the likelihood's feature groups",
            "weights of the likelihood: positions, distances between joints, log_speed of joints",
            unit="weights",
            legal="parts",
        ),
    ] = None
    variance_floor: Annotated[
        VarianceFloor,
        setting(
            "Floors on the variances of the likelihood's feature groups",
            "larger: small differences of poses count less, more is merged",
            unit="m², m², 1",
            legal="parts",
        ),
    ] = VarianceFloor()
    edges: Annotated[
        int,
        setting(
            "N, the edges of a segment graph", "N of the path kernel; more: finer and slower", low=1, high=45
        ),
    ] = 20
    layers: Annotated[
        int,
        setting(
            "L, the layers of the temporal pyramid",
            "L of the path kernel's pyramid; more: the order of poses counts",
            low=1,
            high=5,
        ),
    ] = 1
    kernel_form: Annotated[
        KernelForm,
        setting(
            "Form of the path kernel: `damped` (ours), `sum` or `normalised` (the paper's)",
            "damped (ours), sum or normalised (the paper's)",
        ),
    ] = "damped"
    short_segment: Annotated[
        float | None,
        setting(
            "Merge costs weigh less on sides shorter than this; 0 is off",
            "longer: short segments are merged sooner; 0 is off",
            unit="s",
            low=0.0,
            high=60.0,
        ),
    ] = None
    location: Annotated[
        Location | None,
        setting(
            "Whether a final key frame moves to the likeliest place: `none`, anywhere near (`free`), or to another candidate of Algorithm 2 (`candidates`). Only with another similarity than `evidence`",
            "whether a final key frame may move to a likelier place: none, free, candidates",
        ),
    ] = None
    refine: Annotated[
        float | None,
        setting(
            "Largest distance that it moves",
            "larger: a final key frame may move farther",
            unit="s",
            low=0.0,
            high=5.0,
        ),
    ] = None
    pre_roll: Annotated[
        float | None,
        setting(
            "Assumed time for which the first posture was held before the take. Only with another similarity than `evidence`, like `post_roll` and `features`",
            "longer: the first onset is stronger",
            unit="s",
            low=0.0,
            high=60.0,
        ),
    ] = None
    post_roll: Annotated[
        float | None,
        setting(
            "The same for the last posture, after the take",
            "longer: the last offset is stronger",
            unit="s",
            low=0.0,
            high=60.0,
        ),
    ] = None
    tempo: Annotated[
        bool | None,
        setting(
            "Whether the level follows the performer's own time: how long the extent of the movements takes at the usual speed. At level `motion` rests, periods and the delay of slow performers are longer, changes count less where they move steadily, and repetitions end in the middle of the pause; with `similarity=likelihood` the strength scales with it",
            "true: slow performers keep as many key frames as quick ones",
        ),
    ] = None
    level: Annotated[
        LevelName | float,
        setting(
            "`posture`, `motion`, `cluster`, or a strength (β of Algorithm 3). A name brings its bundle of the fields above",
            "posture keeps every key frame, motion single moves, cluster activities; a number is a strength, larger keeps fewer",
            low=0.0,
            high=1e9,
            legal="posture, motion, cluster or a number >= 0",
        ),
    ] = "motion"
    max_key_frames: Annotated[
        int | None,
        setting(
            "α of Algorithm 3 (offline): merging stops when this many key frames are left, whatever the level; None for the level alone",
            "offline: at least so many key frames are kept, the strongest, whatever the level",
            low=0,
            high=1_000_000,
        ),
    ] = None
    remerge_window: Annotated[
        int | None,
        setting(
            "W, the undecided key frames kept while streaming",
            "more: later context decides, final comes later; work and memory grow",
            unit="key frames",
            low=1,
            high=1024,
        ),
    ] = None
    remerge_seconds: Annotated[
        float | None,
        setting(
            "Time until the oldest undecided key frame is decided, in frame time",
            "longer: final is more reliable and comes later",
            unit="s",
            low=0.05,
            high=1e9,
        ),
    ] = None
    max_gap: Annotated[
        float,
        setting(
            "A missing joint keeps its position for this time; also the longest time step that counts as duration",
            "longer: a missing joint keeps its position longer",
            unit="s",
            low=0.0,
            high=60.0,
        ),
    ] = 0.25
    max_speed: Annotated[
        float,
        setting(
            "A joint faster than this is an outlier",
            "smaller: more of a quick move counts as outliers",
            unit="m/s",
            low=0.1,
            high=1e4,
        ),
    ] = 15.0
    max_pause: Annotated[
        float,
        setting(
            "A gap or a step back in time longer than this starts a new take",
            "longer: a take survives longer pauses of its sender",
            unit="s",
            low=0.05,
            high=3600.0,
        ),
    ] = 1.0
    rest_seconds: Annotated[
        float,
        setting(
            "Time for which the speed must be below the line until an activity event reports `resting`",
            "longer: `resting` is reported later, and shorter rests are part of the movement",
            unit="s",
            low=0.05,
            high=60.0,
        ),
    ] = 0.25
    rests: Annotated[
        Rests | None,
        setting(
            "Whether holds and rests of 0.6 s and more are segments of their own (`keep`, that of level `motion`), or the level decides (`merge`)",
            "keep: holds and rests of 0.6 s and more are segments of their own; merge: the level alone decides",
        ),
    ] = None
    repetitions: Annotated[
        bool,
        setting(
            "Whether to count repetitions", "true: counts how often movements are repeated, and how fast"
        ),
    ] = False
    phase: Annotated[
        bool,
        setting(
            "Whether to emit the position in the cycle of a repeated movement with each frame; needs `repetitions`",
            "true: with repetitions, emits the position in the cycle with each frame",
        ),
    ] = False
    limbs: Annotated[
        bool | str,
        setting(
            "Whether limbs have key frames and segments of their own: True for limbs known by the joints' names, or else by the hierarchy; a text names others, as `left_arm=LeftElbow,LeftHand;tail=TailTip`",
            "true: arms, legs and trunk have key frames of their own; or NAME=JOINT,...;...",
            legal="true, false or groups as in arm=LeftElbow,LeftHand",
        ),
    ] = False
    steps: Annotated[
        bool,
        setting(
            "Whether to report when feet leave the ground and come down",
            "true: reports when feet leave the ground and come down",
        ),
    ] = False
    feet: Annotated[
        str,
        setting(
            "Joints or markers of the feet, as `left=LANK,LTOE right=RANK,RTOE`; empty: those known by name",
            "for steps: left=JOINT,... right=JOINT,...; empty: those known by name",
            legal="a text as in left=LANK,LTOE right=RANK,RTOE",
        ),
    ] = ""
    step_sensitivity: Annotated[
        float,
        setting(
            "Sensitivity of steps: a step goes at least 6 cm / sensitivity",
            "larger: smaller and slower movements of a foot are steps",
            low=0.1,
            high=10.0,
        ),
    ] = 1.0
    up: Annotated[
        Up,
        setting(
            "Axis that points upwards, for steps and for moves that are followed: `y`, `-z` and so on; `auto`: for steps from the feet to the head, else `y`",
            "the axis that points upwards, as y or -z; auto: for steps from the feet to the head, else y",
        ),
    ] = "auto"
    follow_every: Annotated[
        float,
        setting(
            "Time between two `progress` events of a move that is followed; 0 for every frame processed",
            "longer: fewer progress events of a move that is followed",
            unit="s",
            low=0.0,
            high=60.0,
        ),
    ] = 0.1

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            msgspec.structs.force_setattr(self, name, _plain(getattr(self, name)))
        for name, meta in SETTING_METAS.items():
            if not meta.allows(value := getattr(self, name)):
                raise SettingsError(_refusal(name, value))
        _check_groups(self)
        if isinstance(self.limbs, str):
            parse_groups(self.limbs)
        if self.feet:
            parse_feet(self.feet)
        if self.phase and not self.repetitions:
            raise SettingsError("setting phase needs repetitions")
        _check_combination(self)
        if self.range == "fixed" and not (self.range_max is not None and self.range_max > self.range_min):
            raise SettingsError("setting range=fixed needs range_max above range_min (m over the window)")

    @classmethod
    def build(cls, preset: str = "default", overrides: Mapping[str, object] | None = None) -> "Settings":
        """Return the settings of a preset with some fields overridden.

        Args:
            preset: `paper`, `default` or `game`.
            overrides: Field names and values; numbers may be given as text. `features` and `variance_floor`
                take a mapping or one field each as `features.positions`.

        Raises:
            SettingsError: If a name is unknown or a value illegal.
        """
        if preset not in PRESETS:
            raise SettingsError(f"no preset called {preset!r}; there are {', '.join(PRESETS)}")
        values = dict(PRESETS[preset])
        for name, value in (overrides or {}).items():
            _override(values, name, value)
        return _convert(values, cls)

    def replace(self, **changes: object) -> "Settings":
        """Return a copy with some fields changed, validated like `build`.

        Raises:
            SettingsError: If a name is unknown or a value illegal.
        """
        values = msgspec.structs.asdict(self)
        for name, value in changes.items():
            _override(values, name, value)
        return _convert(values, type(self))

    @property
    def bundle(self) -> Literal["motion", "posture", "cluster"]:
        """The bundle that the level brings: its own if it has a name, that of `motion` if it is a strength."""
        return self.level if isinstance(self.level, str) else "motion"

    def bundle_values(self) -> dict[str, object]:
        """Return the bundle's value of each field that is left to the level.

        Five follow another field. `range_floor` is a speed, so it is proportional to `window`. `location` is `none` with the
        path kernel, whose summaries have no sums from which poses could be subtracted. `rate_limit` is 0 with a `fixed`
        range, where key frames are exactly those of Algorithm 2 on the velocity of all frames. `rests` is `merge` with other
        similarities than evidence, where Algorithm 3 alone decides. Level `motion` follows the performer's own time (`tempo`) only
        by evidence, and while `remerge_seconds` is not given: that delay is the same for all performers.
        """
        values = dict(BUNDLES[self.bundle])
        usual = float(str(values["window"]))
        floor = float(str(values.get("range_floor", RANGE_FLOOR_SPEED * usual)))
        values["range_floor"] = floor * (usual if self.window is None else self.window) / usual
        if self.similarity == "path_kernel":
            values["location"] = "none"
        if self.range == "fixed":
            values["rate_limit"] = 0.0
        if self.similarity not in (None, "evidence"):
            values["rests"] = "merge"
        if self.bundle == "motion" and (
            self.remerge_seconds is not None or self.similarity not in (None, "evidence")
        ):
            values["tempo"] = False
        return values

    def at_level(self, level: LevelName | float) -> "Settings":
        """Return these settings with the bundle that a named level brings; a number leaves the bundle."""
        other = self.replace(level=level)
        return other if isinstance(level, str) and other.bundle != self.bundle else self

    def strength(self, level: LevelName | float) -> float:
        """Return the strength that a level stands for within the bundle of these settings.

        Raises:
            SettingsError: If it is a name that has another bundle, which a strength cannot bring.
        """
        if not isinstance(level, str):
            return float(level)
        if self.at_level(level) is not self:
            raise SettingsError(
                f"level {level} works with other settings than those in force: segment again with Settings(level={level!r}), or "
                f"Segmenter.change(level={level!r}), which starts a new take; a number moves the level at once, 0 keeps all"
            )
        similarity = self.similarity or str(BUNDLES[self.bundle]["similarity"])
        measure = self.kernel_form if similarity == "path_kernel" else similarity
        return STRENGTHS[measure][level]

    def resolved(self) -> "ResolvedSettings":
        """Return a copy in which every field left to the level's bundle has its value."""
        values = msgspec.structs.asdict(self)
        for name, value in self.bundle_values().items():
            if values[name] is None:
                values[name] = value
        return msgspec.convert(values, ResolvedSettings)


SETTING_METAS = metas_of(Settings)
document(Settings, SETTING_METAS)
SETTING_LIMITS = {
    name: meta.limits for name, meta in SETTING_METAS.items() if meta.limits and name != "level"
}
SETTING_CHOICES: dict[str, tuple[str | None, ...]] = {
    name: (*meta.choices, None) if meta.optional else meta.choices
    for name, meta in SETTING_METAS.items()
    if meta.choices and name != "level"
}


def settings_or_default(settings: object) -> Settings:
    """Return the given settings, for None the default.

    Raises:
        TypeError: If it is something else.
    """
    if settings is None:
        return Settings()
    if not isinstance(settings, Settings):
        raise TypeError(f"settings are Settings, not {type(settings).__name__}; Settings(level='cluster')")
    return settings


class ResolvedSettings(Settings, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings with nothing left to a bundle."""

    rate_limit: float
    window: float
    similarity: SimilarityName
    remerge_window: int
    range_floor: float
    features: Features
    short_segment: float
    location: Location
    refine: float
    pre_roll: float
    post_roll: float
    tempo: bool
    remerge_seconds: float
    rests: Rests


# Fields that other similarities use.
NOT_OF_EVIDENCE = (
    "features",
    "location",
    "pre_roll",
    "post_roll",
)


def _check_combination(settings: Settings) -> None:
    """Refuse a combination that the bundle in force does not support; name the missing setting."""
    if settings.similarity == "evidence" and settings.bundle != "motion":
        raise SettingsError(
            f"similarity=evidence belongs to level motion, not {settings.bundle}; leave one of them out"
        )
    if (settings.similarity or BUNDLES[settings.bundle]["similarity"]) != "evidence":
        return
    usual = {**BUNDLES["motion"], "features": msgspec.convert(BUNDLES["motion"]["features"], Features)}
    for name in NOT_OF_EVIDENCE:
        if getattr(settings, name) not in (None, usual[name]):
            raise SettingsError(
                f"setting {name} needs similarity=likelihood, or level posture or cluster, whose similarity that is"
            )


def _check_groups(settings: Settings) -> None:
    groups: list[tuple[str, Features | VarianceFloor | None, float]] = [
        ("features", settings.features, 0.0),
        ("variance_floor", settings.variance_floor, 1e-12),
    ]
    for field, group, low in groups:
        if group is not None and not isinstance(group, Features | VarianceFloor):
            raise SettingsError(
                f"setting {field} is {group!r}; it must be a {field.title().replace('_', '')}"
            )
        for name in group.__struct_fields__ if group is not None else ():
            value = getattr(group, name)
            if not low <= value <= 1e3:
                raise SettingsError(
                    f"setting {field}.{name} is {value}; it must lie between {low:g} and 1000"
                )
    if settings.features is not None and not any(msgspec.structs.astuple(settings.features)):
        raise SettingsError("setting features has no weight above 0")


def _convert(values: dict[str, object], record: "type[Settings]") -> "Settings":
    try:
        return msgspec.convert(values, record, strict=False)
    except msgspec.ValidationError as error:
        raise SettingsError(_explain(str(error), values)) from None


def _override(values: dict[str, object], name: str, value: object) -> None:
    field, _, part = name.partition(".")
    if field not in Settings.__struct_fields__:
        raise SettingsError(_unknown(name))
    if not part:
        values[field] = _parse_group(field, value) if isinstance(value, str) else _plain(value)
        return
    group = values.get(field)
    if field not in ("features", "variance_floor"):
        raise SettingsError(f"setting {field} has no part called {part!r}")
    base = msgspec.to_builtins(group) if group is not None else {}
    values[field] = {**base, part: _number(value) if isinstance(value, str) else _plain(value)}


def _unknown(name: str) -> str:
    """Return the message about an unknown setting, with the nearest known one."""
    fields = Settings.__struct_fields__
    near = difflib.get_close_matches(name.lower().replace("-", "_"), fields, 1)
    hint = f" - did you mean {near[0]}?" if near else f"; there are {', '.join(fields)}"
    return f"no setting called {name[:40]!r}{hint}"


def _explain(message: str, values: Mapping[str, object]) -> str:
    """Turn msgspec's message into one that names the field, its value and the legal ones."""
    path = message.partition(" - at `$.")[2]
    field = path.rstrip("`").partition(".")[0]
    if not field:
        return message
    if field in ("features", "variance_floor"):
        return f"setting {field} is {values.get(field)!r}; its parts are {', '.join(Features.__struct_fields__)}, each a number"
    return _refusal(field, values.get(field))


def _refusal(name: str, value: object) -> str:
    return f"setting {name} is {value!r}; it must {SETTING_METAS[name].rule}"


def _parse_group(field: str, value: str) -> object:
    """Read `positions:0.75,log_speed:0.25` and the words none/null/auto of optional fields."""
    if field in ("features", "variance_floor"):
        parts = [part.partition(":") for part in value.split(",")]
        return {name.strip(): _number(text) for name, _, text in parts}
    if field == "limbs" and value.lower() in ("true", "false"):
        return value.lower() == "true"
    if value in ("none", "null", "auto") and field not in ("smoothing", "location", "up"):
        return None
    return value if field == "feet" else _number(value)


def _number(text: str) -> object:
    """Return the number that a text stands for, or the text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _plain(value: object) -> object:
    """Return a value, for a number of numpy's the same of Python's."""
    return value.item() if getattr(value, "ndim", None) == 0 and hasattr(value, "item") else value
