import contextlib

import pytest

from mossar_adapters.pose.settings import DEFAULTS
from mossar_stream import MossarError, SettingsError
from mossar_tools.commands import run, segment
from mossar_tools.configuration import known_names
from mossar_tools.declared import values_of
from mossar_tools.options import parse
from mossar_tools.parser import parser_of


@pytest.fixture
def segment_options(tmp_path):
    def read(config):
        path = tmp_path / "mossar.toml"
        path.write_text(config)
        return parse(parser_of("mossar segment", segment), segment.Options, ("demo:", "--config", str(path)))

    return read


@pytest.fixture
def options(tmp_path):
    def read(*arguments, config=None):
        parser = parser_of("mossar run", run)
        if config is not None:
            path = tmp_path / "mossar.toml"
            path.write_text(config)
            arguments = ("--config", str(path), *arguments)
        return parse(parser, run.Options, arguments)

    return read


def test_defaults_go_behind_the_preset(options):
    assert options("demo:").segmentation.settings().remerge_seconds is None
    assert options("demo:", "--preset", "game").segmentation.settings().remerge_seconds == 1.0


@pytest.mark.parametrize(
    "source", ["webcam:", "webcam:1?model=lite", "dance.mp4", "DANCE.MOV", "dance.mp4.pose.npz"]
)
def test_settings_that_suit_pictures_lie_under_those_of_the_user(options, source):
    usual = options(source).segmentation.settings(source)
    assert {name: getattr(usual, name) for name in DEFAULTS} == DEFAULTS
    own = options(source, "--set", "smoothing=none").segmentation.settings(source)
    assert (own.smoothing, own.one_euro_cutoff) == ("none", DEFAULTS["one_euro_cutoff"])


@pytest.mark.parametrize("source", ["demo:", "walk.bvh", "walk.npz", "osc://127.0.0.1:9000"])
def test_other_sources_keep_the_defaults(options, source):
    assert options(source).segmentation.settings(source) == options("demo:").segmentation.settings()


def test_each_recording_of_several_has_the_settings_that_suit_it(segment_options):
    segmentation = segment_options("").segmentation
    smoothings = [segmentation.settings(name).smoothing for name in ("walk.bvh", "dance.mp4")]
    assert smoothings == ["none", "one_euro"]
    assert segmentation.settings("walk.bvh", "dance.mp4").smoothing == "one_euro"


def test_the_preset_goes_behind_the_configuration(options):
    config = 'preset = "game"\n[settings]\nwindow = 0.5'
    assert options("demo:", config=config).segmentation.settings().window == 0.5
    assert (
        options("demo:", "--preset", "paper", config="[settings]\nwindow = 0.5")
        .segmentation.settings()
        .window
        == 0.5
    )


def test_the_configuration_goes_behind_the_command_line(options):
    config = 'preset = "game"\nlevel = "cluster"\nstats = 5\nto = ["a.jsonl", "b.csv"]\n[settings]\nwindow = 0.5\nlayers = 2'
    chosen = options("demo:", "--set", "window=0.7", "--to", "-", "--level", "0.3", config=config)
    settings = chosen.segmentation.settings()
    assert (settings.window, settings.layers, settings.level) == (0.7, 2, 0.3)
    assert settings.remerge_seconds == 1.0
    assert (chosen.streaming.to, chosen.streaming.stats) == (("-",), 5.0)


def test_the_configuration_may_name_sources_and_lists(options):
    chosen = options(config='sources = ["demo:", "a.bvh"]\njoints = ["hip", "hand"]\nquiet = true')
    assert chosen.sources == ("demo:", "a.bvh")
    assert chosen.body.joints == ("hip", "hand")
    assert chosen.messages.quiet


def test_a_configuration_knows_options_by_the_names_that_users_know(segment_options, options):
    assert segment_options("from = 2").begin == 2.0
    assert "begin" not in values_of(options("demo:", config="from = 2"))
    for ours in ("plot_from = 2", "begin = 2"):
        with pytest.raises(MossarError, match=r"there is no option .*; there are .*\bfrom\b"):
            options("demo:", config=ours)


def test_options_of_other_commands_may_stand_in_the_configuration(options):
    assert not {"plot", "keep"} & values_of(options("demo:", config='plot = "x.png"\nkeep = 3')).keys()


def test_an_output_in_the_configuration_may_name_no_file(segment_options):
    assert segment_options("json = true").json == "-"
    assert segment_options('csv = "all.csv"').csv == "all.csv"


def test_feet_in_the_configuration_are_those_of_the_command_line(options):
    wanted = options("demo:", "--feet", "left=LANK,LTOE", "right=RANK").segmentation.settings().feet
    assert wanted == "left=LANK,LTOE right=RANK"
    for text in ('["left=LANK,LTOE", "right=RANK"]', '"left=LANK,LTOE right=RANK"'):
        assert options("demo:", config=f"feet = {text}").segmentation.settings().feet == wanted


def test_no_value_of_a_configuration_crashes(options, segment_options):
    for name in (*known_names(), *values_of(segment.Options()), "file", "target"):
        for value in (
            "5.0",
            "-1",
            "true",
            '"a"',
            "[]",
            "[1, 2]",
            '["a", "b"]',
            "[[1], [2]]",
            "{a = 1}",
            "1979-05-27",
        ):
            for read in (lambda config: options("demo:", config=config), segment_options):
                with contextlib.suppress(MossarError):
                    read(f"{name} = {value}")


def test_tables_in_the_settings_are_parts(options):
    chosen = options("demo:", config="[settings.features]\npositions = 0.5\nlog_speed = 0.5")
    assert chosen.segmentation.settings().features.log_speed == 0.5


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ("= 3", "not valid TOML"),
        ("nothing = 1", "there is no option 'nothing'"),
        ('preset = "fast"', "preset must be one of paper, default, game"),
        ("quiet = 1", "quiet must be true or false"),
        ("stats = true", "stats cannot be True"),
        ("stats = -1", "not a positive number"),
        ("settings = 3", "settings must be a table"),
        ("sources = 3", "sources must be a list"),
        ("[settings]\nfoo = 1", "no setting called 'foo'; there are"),
        ("[settings]\nwindow = 99", "setting window is 99.0; it must lie between"),
        ('level = "strong"', "it must be posture, motion, cluster or a number"),
        ("to = [1, [2]]", "to cannot be"),
        ("fps = " + "9" * 5000, "value has 5000 digits"),
        ("fps = 0x" + "f" * 5000, "not valid TOML: there is an integer of more than 64 bits"),
        ('moves = "a\\u0000b"', "not valid TOML: there is a NUL character in"),
        ('sources = ["demo:\\u0000"]', "NUL character"),
        ('[settings]\nlimbs = "a\\u0000=b"', "NUL character"),
        ('"a\\u0000" = 1', "NUL character"),
        ("a=" + "[" * 5000 + "]" * 5000, "not valid TOML"),
        ("feet = 5.0", "feet must be 2 texts, each SIDE=JOINT,..., not 5.0"),
        ("feet = {left = 1, right = 2}", "feet must be 2 texts"),
        ('feet = ["left=LTOE"]', "feet must be 2 texts"),
        ("feet = [[1], [2]]", "feet cannot be [1]"),
        ("feet = [1, 2]", "setting feet is '1 2'; it must name one to 4 joints of each foot"),
    ],
)
def test_a_wrong_configuration_is_named_with_its_file(options, config, message):
    with pytest.raises(MossarError, match=r"mossar\.toml") as caught:
        options("demo:", config=config)
    assert message in str(caught.value)


def test_a_setting_of_the_configuration_may_be_completed_on_the_command_line(options):
    config = '[settings]\nrange = "fixed"'
    assert options("demo:", "--set", "range_max=2", config=config).segmentation.settings().range_max == 2
    with pytest.raises(MossarError, match=r"mossar\.toml: setting range=fixed needs range_max"):
        options("demo:", config=config)
    with pytest.raises(SettingsError, match=r"^no setting called 'bar'"):
        options("demo:", "--set", "bar=1", config=config)


def test_the_last_of_two_equal_settings_counts(options):
    assert (
        options("demo:", "--set", "window=0.3", "--set", "window=0.4").segmentation.settings().window == 0.4
    )
