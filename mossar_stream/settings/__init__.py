"""Settings of a segmenter: one frozen record, validated once.

Fields that are None take their value from the bundle of the named level (`presets.py`); `Settings.resolved`
fills them in. The names are those of the command line's `--set name=value`.
"""

import difflib
from collections.abc import Mapping
from typing import Any, Literal, get_args

import msgspec

from mossar_stream.errors import SettingsError
from mossar_stream.settings.feet import parse_feet
from mossar_stream.settings.limb_groups import parse_groups
from mossar_stream.settings.limits import SETTING_LIMITS
from mossar_stream.settings.presets import BUNDLES, PRESETS, RANGE_FLOOR_SPEED, STRENGTHS
from mossar_stream.settings.texts import number, parse_group, plain

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
    """Weights of the feature groups in the likelihood; each is shared equally by the group's dimensions."""

    positions: float = 0.0
    distances: float = 0.0
    log_speed: float = 0.0


class VarianceFloor(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Floor on the variance of each feature group: m², m², and log(m/s) squared."""

    positions: float = 0.001
    distances: float = 0.003
    log_speed: float = 0.1


class _NamedFields(msgspec.StructMeta):
    """Lets a record refuse an unknown field by naming those that there are."""

    def __call__(self, *args: Any, **fields: Any) -> Any:
        if unknown := next((name for name in fields if name not in self.__struct_fields__), None):
            raise TypeError(_unknown(unknown))
        return super().__call__(*args, **fields)


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, metaclass=_NamedFields):
    """Everything that can be set on a segmenter.

    Args:
        rate_limit: Highest rate at which frames are processed, Hz; those between are counted and skipped. 0 processes all,
            as a `fixed` range does by default.
        window: Trailing velocity window, s (equation 1; the paper's is 1 s).
        smoothing: `none`, `moving_average` of the velocity (the paper's) or `one_euro` filter on the joints.
        smoothing_window: Length of the moving average, frames (wSize).
        one_euro_cutoff: Minimum cut-off frequency of the One-Euro filter, Hz.
        one_euro_beta: Speed coefficient of the One-Euro filter, Hz per m/s.
        sig_threshold: θ (sigThre), as a share of the velocity range.
        range: Where the range for normalisation comes from: the largest value so far (`running`), the whole
            recording (`file`, offline only), `fixed` bounds, or a `decay`-ing maximum.
        range_min: Lower bound for `fixed`, m of path summed over the joints within the window.
        range_max: Upper bound for `fixed`, m.
        range_half_life: Half-life of the maximum for `decay`, s.
        range_floor: `running` and `decay` never fall below this, m per joint over the window.
        noise_margin: θ · range is at least this many times what the sensor's noise adds to the velocity, for
            `running`, `decay` and `file`; 0 is off.
        center: Body centre that positions are relative to: the skeleton's `root`, or the `centroid`.
        similarity: What compares neighbouring segments: `evidence`, `likelihood` or `path_kernel`.
        features: Weights of the likelihood's feature groups.
        variance_floor: Floors on the variances of the likelihood's feature groups.
        edges: N, the edges of a segment graph, 1 to 45.
        layers: L, the layers of the temporal pyramid, 1 to 5.
        kernel_form: `damped` (ours), `sum` or `normalised` (the paper's).
        short_segment: Merge costs weigh less on sides shorter than this, s; 0 is off.
        location: Whether a final key frame moves to the likeliest place: `none`, anywhere near (`free`), or
            to another candidate of Algorithm 2 (`candidates`). It needs another similarity than `evidence`.
        refine: How far it may move, s.
        pre_roll: How long the first posture is taken to have been held before the take, s. It needs another similarity
            than `evidence`, and so do `post_roll`, `tempo` and `features`.
        post_roll: The same for the last posture, after the take.
        tempo: Whether the level scales with the performer's tempo.
        level: `posture`, `motion`, `cluster`, or a strength. A name brings its bundle of the fields above.
        max_key_frames: Alpha of Algorithm 3 (offline): merging stops when this many key frames are left, so at least so
            many stand, whatever the level says; None for the level alone.
        remerge_window: W, the undecided key frames kept while streaming.
        remerge_seconds: Time until the oldest undecided key frame is decided, s of frame time.
        max_gap: A missing joint is held this long, s; also the longest time step that counts as duration.
        max_speed: A joint faster than this is an outlier, m/s.
        max_pause: A gap or a step back in time longer than this starts a new take, s.
        repetitions: Whether to count how often movements are repeated.
        rest_seconds: How long the speed must have been below the line until an activity event reports `resting`, s.
        rests: Whether holds and rests of 0.6 s and more are segments of their own (`keep`, that of level `motion`), or the level
            decides (`merge`).
        phase: Whether to tell of each frame where in the cycle of a repeated movement it is; needs `repetitions`.
        limbs: Whether limbs have key frames and segments of their own: True for those known by the joints' names, or
            else by the hierarchy; a text names others, as `left_arm=LeftElbow,LeftHand;tail=TailTip`.

        steps: Whether to report when feet leave the ground and come down.
        feet: Which joints or markers are the feet, as `left=LANK,LTOE right=RANK,RTOE`; empty: those known by name.
        step_sensitivity: Larger: smaller and slower movements of a foot are steps; a step goes 6 cm / sensitivity.
        up: Which axis points upwards, for steps and for moves that are followed: `y`, `-z` and so on; `auto`: for steps from
            the feet to the head, else `y`.
        follow_every: Time between two `progress` events of a move that is followed, s; 0 for as many as there can be.

    Raises:
        SettingsError: If a value is outside its legal range; the message names field, value and range.

    Example:
        >>> Settings(level="cluster").resolved().remerge_seconds
        4.4
    """

    rate_limit: float | None = None
    window: float | None = None
    smoothing: Smoothing = "none"
    smoothing_window: int = 1
    one_euro_cutoff: float = 1.5
    one_euro_beta: float = 2.0
    sig_threshold: float = 0.05
    range: RangePolicy = "running"
    range_min: float = 0.0
    range_max: float | None = None
    range_half_life: float = 300.0
    range_floor: float | None = None
    noise_margin: float = 1.5
    center: Center = "root"
    similarity: SimilarityName | None = None
    features: Features | None = None
    variance_floor: VarianceFloor = VarianceFloor()
    edges: int = 20
    layers: int = 1
    kernel_form: KernelForm = "damped"
    short_segment: float | None = None
    location: Location | None = None
    refine: float | None = None
    pre_roll: float | None = None
    post_roll: float | None = None
    tempo: bool | None = None
    level: LevelName | float = "motion"
    max_key_frames: int | None = None
    remerge_window: int | None = None
    remerge_seconds: float | None = None
    max_gap: float = 0.25
    max_speed: float = 15.0
    max_pause: float = 1.0
    rest_seconds: float = 0.25
    rests: Rests | None = None
    repetitions: bool = False
    phase: bool = False
    limbs: bool | str = False
    steps: bool = False
    feet: str = ""
    step_sensitivity: float = 1.0
    up: Up = "auto"
    follow_every: float = 0.1

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            msgspec.structs.force_setattr(self, name, plain(getattr(self, name)))
        for name, (low, high) in SETTING_LIMITS.items():
            value = getattr(self, name)
            if value is not None and not (isinstance(value, int | float) and low <= value <= high):
                raise SettingsError(f"setting {name} is {value!r}; it must lie between {low:g} and {high:g}")
        _check_choices(self)
        level: object = self.level
        known = (
            level in LEVEL_NAMES
            if isinstance(level, str)
            else isinstance(level, int | float) and 0 <= level < 1e9
        )
        if not known:
            raise SettingsError(f"setting level is {level}; it must be {', '.join(LEVEL_NAMES)} or >= 0")
        _check_groups(self)
        if isinstance(self.limbs, str):
            parse_groups(self.limbs)
        if not isinstance(self.feet, str):
            raise SettingsError(f"setting feet is {self.feet!r}; it must be a text")
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
        """Return what the level's bundle gives to each field that is left to it.

        Four follow another field. `range_floor` is a speed, so it is proportional to `window`. `location` is `none` with the
        path kernel, whose summaries have no sums from which poses could be subtracted. `rate_limit` is 0 with a `fixed`
        range, where key frames are exactly those of Algorithm 2 on the velocity of all frames. `rests` is `merge` with other
        similarities than evidence, where Algorithm 3 alone decides.
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


def settings_or_default(settings: object) -> Settings:
    """Return what was given as settings, for None the default.

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


SETTING_CHOICES: dict[str, tuple[str | None, ...]] = {
    "smoothing": get_args(Smoothing),
    "range": get_args(RangePolicy),
    "center": get_args(Center),
    "similarity": (*get_args(SimilarityName), None),
    "kernel_form": get_args(KernelForm),
    "location": (*get_args(Location), None),
    "rests": (*get_args(Rests), None),
    "up": get_args(Up),
}
SWITCHES = ("tempo", "repetitions", "phase", "steps")
NOT_OF_EVIDENCE = (
    "features",
    "location",
    "pre_roll",
    "post_roll",
    "tempo",
)  # what other similarities make use of
WHOLE_NUMBERS = ("smoothing_window", "edges", "layers", "max_key_frames", "remerge_window")


def _check_choices(settings: Settings) -> None:
    for name, choices in SETTING_CHOICES.items():
        if getattr(settings, name) not in choices:
            legal = ", ".join(choice for choice in choices if choice)
            raise SettingsError(f"setting {name} is {getattr(settings, name)!r}; it must be one of {legal}")
    for name in WHOLE_NUMBERS:
        value = getattr(settings, name)
        if value is not None and not isinstance(value, int):
            raise SettingsError(f"setting {name} is {value!r}; it must be a whole number")
    for name in SWITCHES:
        value = getattr(settings, name)
        if not isinstance(value, bool) and not (value is None and name == "tempo"):
            raise SettingsError(f"setting {name} is {value!r}; it must be true or false")
    if not isinstance(settings.limbs, bool | str):
        raise SettingsError(f"setting limbs is {settings.limbs!r}; it must be true, false or a text")


def _check_combination(settings: Settings) -> None:
    """Refuse what the bundle in force cannot do, with what to add."""
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
        values[field] = parse_group(field, value) if isinstance(value, str) else plain(value)
        return
    group = values.get(field)
    if field not in ("features", "variance_floor"):
        raise SettingsError(f"setting {field} has no part called {part!r}")
    base = msgspec.to_builtins(group) if group is not None else {}
    values[field] = {**base, part: number(value) if isinstance(value, str) else plain(value)}


def _unknown(name: str) -> str:
    """Return what to say of a setting that there is not, with the one that may be meant."""
    fields = Settings.__struct_fields__
    near = difflib.get_close_matches(name, fields, 1)
    hint = f" - did you mean {near[0]}?" if near else ""
    return f"no setting called {name[:40]!r}; there are {', '.join(fields)}{hint}"


def _explain(message: str, values: Mapping[str, object]) -> str:
    """Turn msgspec's message into one that names the field, its value and what is legal."""
    text, _, path = message.partition(" - at `$.")
    field = path.rstrip("`").partition(".")[0]
    if not field:
        return message
    if field == "level":
        return (
            f"setting level is {values.get('level')!r}; it must be {', '.join(LEVEL_NAMES)} or a number >= 0"
        )
    choices = [choice for choice in SETTING_CHOICES.get(field, ()) if choice]
    legal = (
        f"; it must be one of {', '.join(map(str, choices))}"
        if choices and isinstance(choices[0], str)
        else ""
    )
    if field in SETTING_LIMITS:
        low, high = SETTING_LIMITS[field]
        kind = "a whole number" if "`int" in text else "a number"
        legal = f"; it must be {kind} between {low:g} and {high:g}"
    elif field in ("features", "variance_floor"):
        legal = f"; its parts are {', '.join(Features.__struct_fields__)}, each a number"
    elif field in SWITCHES:
        legal = "; it must be true or false"
    if legal:
        return f"setting {field} is {values.get(field)!r}{legal}"
    return f"setting {field} is {values.get(field)!r}: {text[0].lower()}{text[1:]}"
