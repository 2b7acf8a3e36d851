"""Settings: names, limits, texts, presets and bundles."""

import re

import msgspec
import numpy as np
import pytest

from mossar_stream import SETTING_LIMITS, SETTING_METAS, Settings, SettingsError
from mossar_stream.settings import LEVEL_NAMES, Features, VarianceFloor
from mossar_stream.settings.presets import BUNDLES, PRESETS, STRENGTHS


def refusal(**changes):
    with pytest.raises(SettingsError) as refused:
        Settings.build("default", changes)
    message = str(refused.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize("name", SETTING_LIMITS)
def test_every_number_has_limits_and_the_message_names_them(name):
    low, high = SETTING_LIMITS[name]
    for value in (high * 1.01 + 1, low - 1, float("nan"), float("inf")):
        if isinstance(value, float) and name in (
            "smoothing_window",
            "edges",
            "layers",
            "max_key_frames",
            "remerge_window",
        ):
            continue
        assert name in refusal(**{name: value})
        with pytest.raises(SettingsError, match=name):
            Settings(**{name: value})
    assert f"between {low:g} and {high:g}" in refusal(**{name: int(high) + 2})


def test_every_setting_is_documented_and_every_number_has_limits():
    arguments = Settings.__doc__.partition("Raises:")[0]
    assert set(re.findall(r"^        (\w+): ", arguments, re.MULTILINE)) == set(Settings.__struct_fields__)
    numbers = {name for name, meta in SETTING_METAS.items() if {int, float} & set(meta.kinds)}
    assert numbers - {"level"} == set(SETTING_LIMITS)
    assert all(meta.text and meta.effect and meta.written for meta in SETTING_METAS.values())


def test_the_schema_has_the_descriptions_and_limits():
    fields = msgspec.json.schema(Settings)["$defs"]["Settings"]["properties"]
    assert (fields["window"]["minimum"], fields["window"]["maximum"]) == SETTING_LIMITS["window"]
    assert all(fields[name]["description"] == meta.text for name, meta in SETTING_METAS.items())


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"quick": 1}, "no setting called 'quick'; there are rate_limit, window, smoothing"),
        ({"windwo": 1}, "no setting called 'windwo'"),
        ({"range": "widest"}, "setting range is 'widest'; it must be one of running, file, fixed, decay"),
        (
            {"similarity": "magic"},
            "setting similarity is 'magic'; it must be one of evidence, likelihood, path_kernel",
        ),
        ({"level": "loud"}, "setting level is 'loud'; it must be posture, motion, cluster"),
        ({"level": -1}, "level is -1"),
        ({"level": "nan"}, "level is nan"),
        ({"window": "wide"}, "setting window is 'wide'"),
        ({"window": [1]}, "setting window is [1]"),
        ({"remerge_window": 2.5}, "remerge_window"),
        ({"remerge_window": "2.5"}, "remerge_window"),
        ({"tempo": "perhaps"}, "tempo"),
        ({"features": "speeds:1"}, "speeds"),
        ({"features": {"positions": -1}}, "features.positions is -1"),
        ({"features": {"positions": 0}}, "features has no weight above 0"),
        ({"features.speed": 1}, "speed"),
        ({"variance_floor.positions": 0}, "variance_floor.positions is 0"),
        ({"window.width": 1}, "setting window has no part called 'width'"),
        ({"range": "fixed"}, "range=fixed needs range_max above range_min"),
        ({"range": "fixed", "range_min": 2, "range_max": 2}, "range=fixed needs range_max above range_min"),
    ],
    ids=str,
)
def test_what_is_wrong_is_said_in_one_line(changes, said):
    assert said in refusal(**changes)


@pytest.mark.parametrize(
    "wrong",
    [
        {"range": "widest"},
        {"level": "loud"},
        {"smoothing": None},
        {"location": "near"},
        {"features": {"positions": 1.0}},
        {"remerge_window": 2.5},
        {"center": "hips"},
    ],
    ids=str,
)
def test_the_constructor_refuses_what_build_refuses(wrong):
    with pytest.raises(SettingsError):
        Settings(**wrong)


def test_numbers_may_be_texts_and_words_turn_off_what_is_optional():
    chosen = Settings.build(
        "default",
        {
            "window": "0.3",
            "remerge_window": "4",
            "tempo": "true",
            "similarity": "likelihood",
            "max_key_frames": "none",
            "level": "0.5",
            "pre_roll": "auto",
        },
    )
    assert (chosen.window, chosen.remerge_window, chosen.tempo, chosen.level) == (0.3, 4, True, 0.5)
    assert (chosen.max_key_frames, chosen.pre_roll) == (None, None)
    assert Settings.build("default", {"location": "none", "smoothing": "none"}).location == "none"


def test_groups_are_given_whole_or_by_part():
    whole = Settings.build("default", {"level": "posture", "features": "positions:0.75,log_speed:0.25"})
    parts = Settings.build(
        "default", {"level": "posture", "features.positions": 0.75, "features.log_speed": "0.25"}
    )
    assert whole.features == parts.features == Features(positions=0.75, log_speed=0.25)
    floors = Settings.build("default", {"variance_floor.distances": 0.5}).variance_floor
    assert floors == VarianceFloor(distances=0.5)


def test_an_unknown_preset_is_refused_with_the_known_ones():
    with pytest.raises(SettingsError, match="no preset called 'fast'; there are default, paper, game"):
        Settings.build("fast")


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("level", [*LEVEL_NAMES, 0.0, 0.7])
def test_every_preset_resolves_at_every_level_with_nothing_left_open(preset, level):
    resolved = Settings.build(preset, {"level": level}).resolved()
    optional = {"max_key_frames", "range_max"}
    assert all(
        getattr(resolved, name) is not None for name in resolved.__struct_fields__ if name not in optional
    )


def test_the_papers_preset_has_the_papers_values():
    paper = Settings.build("paper").resolved()
    assert (paper.window, paper.sig_threshold, paper.smoothing, paper.range_floor) == (1.0, 0.01, "none", 0.0)
    assert (paper.similarity, paper.kernel_form, paper.edges, paper.layers) == (
        "path_kernel",
        "normalised",
        20,
        1,
    )
    assert (paper.noise_margin, paper.location, paper.pre_roll, paper.tempo) == (0.0, "none", 0.0, False)


@pytest.mark.parametrize("name", BUNDLES)
def test_a_named_level_brings_its_bundle_and_what_is_given_stays(name):
    resolved = Settings(level=name).resolved()
    features = Features(**BUNDLES[name]["features"])
    assert {field: getattr(resolved, field) for field in BUNDLES[name]} == {
        **BUNDLES[name],
        "features": features,
    }
    kept = Settings(level=name, window=0.4, refine=0.05, tempo=None).resolved()
    assert (kept.window, kept.refine) == (0.4, 0.05)
    # The floor of the range follows the window: it is a speed.
    assert kept.range_floor == pytest.approx(resolved.range_floor * 0.4 / resolved.window)


@pytest.mark.parametrize(
    ("preset", "level", "rests"),
    [
        ("default", "motion", "keep"),
        ("default", 2.0, "keep"),
        ("game", "motion", "keep"),
        ("default", "posture", "merge"),
        ("game", "cluster", "merge"),
        ("paper", "motion", "merge"),
    ],
)
def test_level_motion_keeps_rests_unless_the_preset_is_the_papers(preset, level, rests):
    settings = Settings.build(preset, {"level": level})
    assert settings.resolved().rests == rests
    assert settings.replace(rests="merge").resolved().rests == "merge"
    assert settings.replace(rests="keep").resolved().rests == "keep"


# Values that no bundle has, one for each field; some are legal with others only.
ALONE = {
    "rate_limit": [17.0],
    "window": [0.33],
    "smoothing": ["moving_average", "one_euro"],
    "smoothing_window": [5],
    "one_euro_cutoff": [2.5],
    "one_euro_beta": [3.5],
    "sig_threshold": [0.07],
    "range": ["decay", "file", "fixed"],
    "range_min": [0.1],
    "range_max": [7.0],
    "range_half_life": [33.0],
    "range_floor": [0.33],
    "noise_margin": [0.5],
    "center": ["centroid"],
    "similarity": ["evidence", "likelihood", "path_kernel"],
    "features": [Features(positions=1.0)],
    "variance_floor": [VarianceFloor(positions=0.5)],
    "edges": [7],
    "layers": [2],
    "kernel_form": ["sum", "normalised"],
    "short_segment": [0.7],
    "location": ["free", "candidates", "none"],
    "refine": [0.7],
    "pre_roll": [0.7],
    "post_roll": [0.7],
    "tempo": [True, False],
    "max_key_frames": [7],
    "remerge_window": [7],
    "remerge_seconds": [0.7],
    "max_gap": [0.7],
    "max_speed": [7.0],
    "max_pause": [0.7],
    "rest_seconds": [0.7],
    "rests": ["merge", "keep"],
    "steps": [True],
    "feet": ["left=a right=b"],
    "step_sensitivity": [0.7],
    "up": ["z"],
    "follow_every": [0.7],
    "repetitions": [True],
    "phase": [True],
    "limbs": [True],
}
# What follows another field, as `mossar settings` shows.
FOLLOWS = {
    "range_floor": ["window"],
    "location": ["similarity"],
    "rate_limit": ["range"],
    "rests": ["similarity"],
    "tempo": ["similarity", "remerge_seconds"],
}


def resolved_alone(make, name, value, **others):
    """Return the values in force with one field set; nothing where it is refused alone."""
    try:
        return msgspec.structs.asdict(make({name: value, **others}).resolved())
    except SettingsError:
        assert name in refusal(**{name: value, **others})
        return {}


@pytest.mark.parametrize("level", LEVEL_NAMES)
@pytest.mark.parametrize("name", sorted(set(Settings.__struct_fields__) - {"level"}))
def test_a_field_never_changes_another(name, level):
    ways = [
        lambda fields: Settings(**fields),
        lambda fields: Settings.build("default", fields),
        lambda fields: Settings.build("default", {k: msgspec.to_builtins(v) for k, v in fields.items()}),
    ]
    for make in ways:
        usual = msgspec.structs.asdict(make({"level": level}).resolved())
        for value in ALONE[name]:
            found = resolved_alone(make, name, value, level=level)
            changed = {field for field in found if found[field] != usual[field]} - {name}
            assert all(name in FOLLOWS.get(field, []) for field in changed)


@pytest.mark.parametrize("name", ["features", "location", "pre_roll", "post_roll"])
def test_what_a_bundle_cannot_do_is_refused_with_what_to_add(name):
    said = refusal(**{name: ALONE[name][0]})
    assert f"setting {name} needs similarity=likelihood" in said
    assert Settings(**{name: ALONE[name][0], "similarity": "likelihood"}).bundle == "motion"
    assert Settings(**{name: ALONE[name][0], "level": "posture"}).bundle == "posture"


def test_motion_follows_the_performers_own_time_unless_its_delay_is_given():
    assert Settings().resolved().tempo
    assert not Settings(remerge_seconds=1.4).resolved().tempo
    assert not Settings.build("game", {}).resolved().tempo
    assert not Settings(similarity="likelihood").resolved().tempo
    assert not Settings.build("paper", {}).resolved().tempo
    assert Settings(remerge_seconds=1.4, tempo=True).resolved().tempo
    assert Settings.build("game", {"level": "posture"}).resolved().tempo


def test_evidence_belongs_to_level_motion():
    assert "similarity=evidence belongs to level motion, not cluster" in refusal(
        similarity="evidence", level="cluster"
    )
    assert Settings(similarity="evidence").resolved() == Settings().resolved()


def test_levels_are_strengths_that_rise():
    for values in STRENGTHS.values():
        assert values["posture"] == 0.0
        assert 0 < values["motion"] < values["cluster"]
    assert Settings().strength(0.123) == 0.123
    assert Settings(level="cluster").strength("cluster") == STRENGTHS["likelihood"]["cluster"]
    with pytest.raises(SettingsError, match="level motion works with other settings than those in force"):
        Settings(level="cluster").strength("motion")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"window": "x"}, "setting window is 'x'; it must lie between 0.01 and 10"),
        ({"edges": np.zeros(2)}, "setting edges is array"),
        ({"level": None}, "setting level is None; it must be posture"),
        ({"tempo": "yes"}, "setting tempo is 'yes'; it must be true or false"),
        ({"repetitions": 2}, "setting repetitions is 2; it must be true or false"),
        ({"limbs": 5}, "setting limbs is 5"),
    ],
)
def test_values_of_another_kind_are_refused(changes, said):
    with pytest.raises(SettingsError, match=re.escape(said)):
        Settings(**changes)


def test_numbers_may_be_of_numpy():
    wanted = {"window": 0.5, "edges": 7, "level": 0.25, "repetitions": True}
    kinds = np.float32, np.int16, np.float64, np.bool_
    given = {name: kind(value) for (name, value), kind in zip(wanted.items(), kinds, strict=True)}
    for settings in (Settings(**given), Settings.build("default", given), Settings().replace(**given)):
        assert settings == Settings(**wanted)
        assert msgspec.json.decode(msgspec.json.encode(settings), type=Settings) == settings


def test_replace_validates_and_leaves_the_original_alone():
    settings = Settings(window=0.3)
    assert settings.replace(window=0.5).window == 0.5
    assert settings.window == 0.3
    with pytest.raises(SettingsError):
        settings.replace(window=99)
    with pytest.raises(SettingsError):
        settings.replace(widow=1)


def test_settings_survive_a_wire():
    settings = Settings.build(
        "game", {"features.positions": 1, "similarity": "likelihood", "level": 0.3, "max_key_frames": 7}
    )
    assert msgspec.json.decode(msgspec.json.encode(settings), type=Settings) == settings
    with pytest.raises(msgspec.ValidationError):
        msgspec.json.decode(b'{"window": 99}', type=Settings)
    with pytest.raises(msgspec.ValidationError):
        msgspec.json.decode(b'{"windwo": 1}', type=Settings)


@pytest.mark.parametrize(
    ("make", "kind"),
    [
        (lambda: Settings(windw=1.0), TypeError),
        (lambda: Settings().replace(windw=1.0), SettingsError),
        (lambda: Settings.build("default", {"windw": 1.0}), SettingsError),
    ],
)
def test_an_unknown_field_is_answered_with_the_nearest_and_no_list(make, kind):
    with pytest.raises(kind, match=r"^no setting called 'windw' - did you mean window\?$"):
        make()
