"""Options that several commands share, and the sources of their values.

Precedence: defaults < preset < configuration file < command line. The parsers carry no defaults; the records of options
do, so that given values and defaults can be distinguished.
"""

import argparse
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import msgspec

from mossar_adapters.files.options import METRES, ReadOptions
from mossar_adapters.people import REMEMBERED
from mossar_adapters.usual_settings import usual_settings
from mossar_stream import SETTING_CHOICES, Settings, SettingsError
from mossar_tools import values
from mossar_tools.configuration import read_configuration
from mossar_tools.console import LEVELS
from mossar_tools.declared import Option, Section, declared, nested
from mossar_tools.errors import UsageError

WIDTH = 11.0  # inches of a picture
STANDARD_OUTPUT = "-"
_GROUPS = re.compile(r"\s*[\w-]+\s*=")  # start of a value of --limbs; no file or URL begins like it

Record = TypeVar("Record", bound=msgspec.Struct)

# Options that commands take one by one.
MovesFile = Annotated[str | None, Option("recognise the moves of this file; see mossar teach", "FILE")]
Followed = Annotated[
    tuple[str, ...],
    Option(
        "follow these moves of --moves while they are made; progress, tempo, count, deviation; NAME,NAME or all",
        "NAMES|all",
        values.names,
    ),
]
Begin = Annotated[
    float | None, Option("begin of the part, s of the recording's clock", "S", values.seconds, flag="from")
]
Until = Annotated[float | None, Option("end of the part, s of the recording's clock", "S", values.seconds)]
Speed = Annotated[
    float | Literal["max"] | None, Option("1 is real time; 2, 0.5, max (default: 1)", "X", values.speed)
]
SpeedOfReading = Annotated[
    float | Literal["max"] | None,
    Option("1 is real time; 2, 0.5, max (default: max for recordings, 1 for demo:)", "X", values.speed),
]


def output(what: str) -> Option:
    """Return `--json [FILE]` or `--csv [FILE]`."""
    return Option(f"{what}; to standard output without FILE", "FILE", nargs="?", const=STANDARD_OUTPUT)


Preset = Annotated[
    Literal["paper", "default", "game"],
    Section("segmentation"),
    Option("preset of the settings (default: default)"),
]
Level = Annotated[str | None, Option("posture, motion, cluster, or a strength as a number", "LEVEL")]
Chosen = Annotated[
    dict[str, Any],
    Option("any setting, as in --set window=0.3; repeatable", "NAME=VALUE", values.setting, repeatable=True),
]
Rests = Annotated[
    str | None,
    Option(
        "keep: holds and rests of 0.6 s and more are separate segments; merge: the level decides",
        choices=tuple(choice for choice in SETTING_CHOICES["rests"] if choice),
    ),
]
Configuration = Annotated[
    str | None,
    Option("a file with these options: long names without dashes, [settings] for --set", "FILE.toml"),
]


class _Settings(msgspec.Struct, frozen=True):
    """Options of segmentation; an option with the name of a setting is that setting."""

    def settings(self, *sources: str, **overrides: object) -> Settings:
        """Return the settings of the segmenter; the user's take precedence over those that suit the sources.

        Args:
            sources: URLs and recordings to segment.
            overrides: Settings of this command; the user's take precedence.

        Raises:
            SettingsError: If a name is unknown or a value illegal.
        """
        given = msgspec.structs.asdict(self)
        preset, own = given["preset"], given["set"]
        named = {
            name: _as_setting(name, value)
            for name, value in given.items()
            if name in Settings.__struct_fields__ and value not in (None, False, ())
        }
        return Settings.build(preset, {**usual_settings(sources), **overrides, **own, **named})


def _as_setting(name: str, value: Any) -> Any:
    if name == "limbs":
        return value or True  # the named limbs, or the usual ones
    return " ".join(value) if name == "feet" else value


class LabelledSegmenting(_Settings, frozen=True):
    """Options of segmentation for recordings whose labels set the level."""

    preset: Preset = "default"
    set: Chosen = {}  # msgspec copies it
    rests: Rests = None
    config: Configuration = None


class BodySegmenting(_Settings, frozen=True):
    """Options of segmentation for commands that report only the body's key frames and segments."""

    preset: Preset = "default"
    level: Level = None
    set: Chosen = {}
    rests: Rests = None
    config: Configuration = None


class Segmenting(_Settings, frozen=True):
    """Options of segmentation, and of reports besides the body's key frames and segments."""

    preset: Preset = "default"
    level: Level = None
    set: Chosen = {}
    rests: Rests = None
    repetitions: Annotated[bool, Option("count repetitions")] = False
    steps: Annotated[bool, Option("report when feet leave the ground and come down")] = False
    feet: Annotated[
        tuple[str, ...],
        Option(
            "for --steps: left=A,B right=C,D, if the joints of the feet are not known by name",
            "SIDE=JOINT,...",
            nargs=2,
        ),
    ] = ()
    limbs: Annotated[
        str | None,
        Option(
            "key frames of each limb, too; arms, legs and trunk, or limbs named with their joints",
            "NAME=JOINT,...;...",
            nargs="?",
            const="",
        ),
    ] = None
    config: Configuration = None


class Body(msgspec.Struct, frozen=True):
    """Options for the content of a frame."""

    joints: Annotated[
        tuple[str, ...], Section("content of a frame"), Option("use these joints only", "A,B,C", values.names)
    ] = ()
    root: Annotated[str | None, Option("joint at the centre of the body", "JOINT")] = None
    unit: Annotated[str, Option("unit of the positions (default: auto)", choices=(*METRES, "auto"))] = "auto"
    fps: Annotated[float | None, Option("rate of frames without a time", "HZ", values.positive)] = None
    skeleton: Annotated[
        str | None, Option("skeleton of the recording, such as the .asf of an .amc", "FILE")
    ] = None
    performer: Annotated[str | None, Option("use this performer only", "NAME")] = None
    allow_2d: Annotated[bool, Option("accept flat poses, which are refused otherwise")] = False

    def reading(self, *, again: bool = False) -> ReadOptions:
        """Return the options for reading a recording.

        Args:
            again: Whether to estimate the poses of a video again, despite the estimate kept beside it.
        """
        return ReadOptions(**msgspec.structs.asdict(self), again=again)


class People(msgspec.Struct, frozen=True):
    """People who get slots instead of the sender's ids."""

    people: Annotated[
        int | Literal["nearest", "first"] | None,
        Section("people"),
        Option(
            "follow N people as p1 to pN, independent of the tracker's ids; nearest or first: one person as p1",
            "N",
            values.people,
        ),
    ] = None
    remember: Annotated[
        float | None,
        Option(
            f"how long an absent person keeps its slot (default: {REMEMBERED:g})", "SECONDS", values.share
        ),
    ] = None


NOBODY = People()


class Messages(msgspec.Struct, frozen=True):
    """Messages on standard error."""

    quiet: Annotated[bool, Section("messages, on standard error"), Option("errors only")] = False
    verbose: Annotated[bool, Option("everything")] = False
    log_level: Annotated[str | None, Option("level of messages (default: info)", choices=LEVELS)] = None
    log_json: Annotated[bool, Option("one JSON object per message")] = False


class Picture(msgspec.Struct, frozen=True):
    """A picture, and whether files may be replaced."""

    plot: Annotated[str | None, Option("draw a picture: .png, .svg or .pdf", "FILE")] = None
    dark: Annotated[bool, Option("a picture for dark pages")] = False
    force: Annotated[bool, Option("replace existing files")] = False


class Streaming(msgspec.Struct, frozen=True):
    """Options of a running pipeline."""

    to: Annotated[
        tuple[str, ...],
        Section("while running"),
        Option("sink of events: a URL, a file or -; repeatable", "SINK", repeatable=True),
    ] = ()
    emit: Annotated[
        tuple[str, ...],
        Option(
            "emit only these types or statuses; types (key_frame segment activity move follow pose repetition phase step stream stats), "
            "statuses (confirmed final ...) or both as key_frame.final; separated by commas",
            "LIST",
            values.names,
        ),
    ] = ()
    moves: MovesFile = None
    follow: Followed = ()
    stats: Annotated[
        float | None, Option("interval of reports of counters and delays", "SECONDS", values.positive)
    ] = None
    metrics: Annotated[
        tuple[str, int] | None, Option("serve counters and delays to Prometheus", "[HOST:]PORT", values.place)
    ] = None
    control: Annotated[
        tuple[str, ...],
        Option(
            "answer requests: zmq+bind://127.0.0.1:5560, or osc with an OSC source", "URL", repeatable=True
        ),
    ] = ()
    snapshot: Annotated[
        str | None, Option("save the state to a file, from which an interrupted run continues", "FILE")
    ] = None
    snapshot_every: Annotated[
        float, Option("interval of saving the state (default: 5)", "SECONDS", values.positive)
    ] = 5.0
    run_id: Annotated[
        str | None,
        Option("name of this run in its events (default: a new name for each run)", "NAME", values.run_id),
    ] = None
    force: Annotated[bool, Option("replace existing files")] = False
    seconds: Annotated[
        float | None,
        Option("stop after this time of the stream", "S", values.positive),
    ] = None


class PageOptions(msgspec.Struct, frozen=True):
    """The page for players, and the dashboard."""

    page: Annotated[
        Literal["player", "dashboard"] | None,
        Section("the page"),
        Option(
            "player: large picture, one count, one verdict; dashboard: curve and sliders (default: player for a camera, and "
            "for senders with --follow, --moves or --repetitions)",
        ),
    ] = None
    port: Annotated[
        int, Option("port of the page (default: 8080, or the next free one)", "N", values.port)
    ] = 8080
    host: Annotated[
        str,
        Option(
            "address of this computer for other devices, 0.0.0.0 for all; each needs a URL that is valid once "
            "(default: 127.0.0.1, this computer only)",
            "ADDRESS",
        ),
    ] = "127.0.0.1"
    no_browser: Annotated[bool, Option("print the URL and open no browser")] = False
    dark: Annotated[bool, Option("begin in dark colours")] = False


def parse(parser: argparse.ArgumentParser, record: type[Record], arguments: Sequence[str]) -> Record:
    """Return the options of the command line and the configuration file.

    Args:
        parser: Parser of the command, without defaults.
        record: The command's options.
        arguments: Arguments after the command's name.

    Raises:
        UsageError: If something is unknown or impossible.
    """
    given = vars(parser.parse_args([*_separated(arguments, record)]))
    path = given.pop("config", None)
    own = dict(given.pop("set", ()))
    configured = read_configuration(Path(path), parser) if path is not None else {}
    settings = {**configured.pop("set", {}), **own}
    given = {name: value for name, value in given.items() if value not in ([], None)}
    merged = {**configured, **given, "config": path, "set": settings}
    if merged.get("quiet") and merged.get("verbose"):
        raise UsageError("--quiet and --verbose cannot be wanted at once")
    if merged.get("remember") is not None and merged.get("people") is None:
        raise UsageError("--remember needs --people N: it says how long absent people are remembered")
    try:
        options = msgspec.convert(nested(record, merged), record)
    except msgspec.ValidationError as error:  # of a configuration: the command line's values have their types
        raise UsageError(f"{path}: {error}") from None
    if path:
        without = msgspec.convert(nested(record, {**given, "set": own}), record)
        _check_settings(path, options, without)
    return options


def _separated(arguments: Sequence[str], record: type[msgspec.Struct]) -> Iterator[str]:
    """Yield the arguments, with `--limbs=` for a `--limbs` that a source follows instead of its value."""
    has_limbs = any(one.flag == "limbs" for one in declared(record))
    for argument, following in zip(arguments, [*arguments[1:], ""], strict=False):
        yield "--limbs=" if has_limbs and argument == "--limbs" and not _GROUPS.match(following) else argument


def _check_settings(path: str, options: Any, without: Any) -> None:
    """Refuse settings that only the configuration file makes wrong; the error names the file."""
    try:
        options.segmentation.settings()
    except SettingsError as error:
        without.segmentation.settings()  # wrong without the file, too
        raise UsageError(f"{path}: {error}") from None
