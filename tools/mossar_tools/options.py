"""Options: what several commands share, and where values come from.

Precedence: defaults < preset < configuration file < command line. The parsers carry no defaults; `Options` does,
so that given values and defaults can be distinguished.
"""

import argparse
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import msgspec

from mossar_adapters.files.options import METRES, ReadOptions
from mossar_adapters.people import REMEMBERED
from mossar_adapters.usual_settings import usual_settings
from mossar_stream import SETTING_CHOICES, Settings, SettingsError
from mossar_tools.configuration import read_configuration
from mossar_tools.console import LEVELS
from mossar_tools.errors import UsageError
from mossar_tools.values import (
    inches,
    names,
    people,
    place,
    port,
    positive,
    run_id,
    seconds,
    setting,
    share,
    speed,
)

WIDTH = 11.0  # inches of a picture
PRESETS = ("paper", "default", "game")
STANDARD_OUTPUT = "-"
_GROUPS = re.compile(r"\s*[\w-]+\s*=")  # how the value of --limbs begins: no file or URL does


class Options(msgspec.Struct, frozen=True):
    """Values of all options of all commands; those that a command does not have keep their defaults."""

    sources: tuple[str, ...] = ()
    config: str | None = None
    file: str = ""
    target: str = ""
    resume: bool = False
    to: tuple[str, ...] = ()
    preset: str = "default"
    level: str | None = None
    set: dict[str, Any] = {}  # msgspec copies it
    joints: tuple[str, ...] = ()
    root: str | None = None
    unit: str = "auto"
    skeleton: str | None = None
    performer: str | None = None
    people: int | Literal["nearest", "first"] | None = None
    remember: float | None = None
    fps: float | None = None
    allow_2d: bool = False
    control: tuple[str, ...] = ()
    moves: str | None = None
    explain: bool = False
    facing: Literal["any", "as_shown"] | None = None
    strict: float | None = None
    again: float | None = None
    mirrored: bool | None = None
    pose: str | None = None
    hold: float | None = None
    follow: tuple[str, ...] = ()
    name: str | None = None
    times: int = 2
    begin: float | None = None
    until: float | None = None
    list: bool = False
    remove: str | None = None
    undo: bool = False
    keeps: bool = False
    discover: bool = False
    names: tuple[str, ...] = ()
    snapshot: str | None = None
    snapshot_every: float = 5.0
    run_id: str | None = None
    emit: tuple[str, ...] = ()
    stats: float | None = None
    metrics: tuple[str, int] | None = None
    speed: float | Literal["max"] | None = None
    seconds: float | None = None
    loop: bool = False
    force: bool = False
    seed: int = 1
    noise: float = 0.0
    performers: int = 1
    json: str | None = None
    csv: str | None = None
    export: tuple[str, ...] = ()
    video: str | None = None
    cut: str | None = None
    of: Literal["segments", "repetitions", "moves", "followed"] = "segments"
    person: str | None = None
    session: str | None = None
    pattern: str | None = None
    repetitions: bool = False
    all: bool = False
    limbs: str | None = None
    rests: str | None = None
    steps: bool = False
    angles: bool = False
    curves: str | None = None
    feet: tuple[str, ...] = ()
    plot: str | None = None
    plot_to: float | None = None  # former name of `until`
    width: float = WIDTH
    dark: bool = False
    keep: int | None = None
    check: str | None = None
    view: bool = False
    page: Literal["player", "dashboard"] | None = None
    port: int = 8080
    get_model: bool = False
    model: str | None = None
    host: str = "127.0.0.1"
    no_browser: bool = False
    seeds: int | None = None
    leave_out: bool = False
    stretch: tuple[float, ...] | None = None
    per_minute: float | None = None
    labels: str | None = None
    tier: str | None = None
    tolerance: tuple[float, ...] = ()
    save: str | None = None
    only: tuple[str, ...] = ()
    quick: bool = False
    quiet: bool = False
    verbose: bool = False
    log_level: str | None = None
    log_json: bool = False

    def settings(self, **overrides: object) -> Settings:
        """Return the settings of the segmenter: those that suit the source lie under the user's.

        Args:
            overrides: What this command sets where the user says nothing.

        Raises:
            SettingsError: If a name is unknown or a value illegal.
        """
        # Of several recordings `file` is the one; that of `teach` holds moves.
        sources = self.sources if self.sources and self.file not in self.sources else (self.file,)
        chosen = {**usual_settings(name for name in sources if name), **overrides, **self.set}
        if self.level is not None:
            chosen["level"] = self.level
        if self.repetitions:
            chosen["repetitions"] = True
        if self.rests is not None:
            chosen["rests"] = self.rests
        if self.limbs is not None:
            chosen["limbs"] = self.limbs or True
        if self.steps:
            chosen["steps"] = True
        if self.feet:
            chosen["feet"] = " ".join(self.feet)
        return Settings.build(self.preset, chosen)

    def reading(self) -> ReadOptions:
        """Return how to read a recording."""
        return ReadOptions(
            self.fps,
            self.unit,
            self.skeleton,
            self.root,
            self.joints,
            self.performer,
            self.allow_2d,
            self.force,
        )


def parse(parser: argparse.ArgumentParser, arguments: Sequence[str]) -> Options:
    """Return what the command line and the configuration file say.

    Args:
        parser: Parser of the command, without defaults.
        arguments: Arguments after the command's name.

    Raises:
        UsageError: If something is unknown or impossible.
    """
    given = vars(parser.parse_args([*_separated(arguments)]))
    path = given.pop("config", None)
    own = dict(given.pop("set", ()))
    configured = read_configuration(Path(path), parser, Options.__struct_fields__) if path else {}
    settings = {**configured.pop("set", {}), **own}
    given = {name: value for name, value in given.items() if value not in ([], None)}
    merged = {**configured, **given, "config": path, "set": settings}
    if merged.get("quiet") and merged.get("verbose"):
        raise UsageError("--quiet and --verbose cannot be wanted at once")
    if merged.get("remember") is not None and merged.get("people") is None:
        raise UsageError("--remember needs --people N: it says how long absent people are remembered")
    try:
        options = msgspec.convert(merged, Options)
    except msgspec.ValidationError as error:  # of a configuration: the command line's values have their types
        raise UsageError(f"{path}: {error}") from None
    if path:
        _check_settings(path, options, msgspec.convert({**given, "set": dict(own)}, Options))
    return options


def _separated(arguments: Sequence[str]) -> Iterator[str]:
    """Yield the arguments, `--limbs` as `--limbs=` where what comes after it is not its value but a source."""
    for argument, following in zip(arguments, [*arguments[1:], ""], strict=False):
        yield "--limbs=" if argument == "--limbs" and not _GROUPS.match(following) else argument


def _check_settings(path: str, options: Options, without: Options) -> None:
    """Refuse settings that are wrong because of a configuration file by the file's name."""
    try:
        options.settings()
    except SettingsError as error:
        without.settings()  # wrong without the file, too
        raise UsageError(f"{path}: {error}") from None


def which_source(command: str, options: Options) -> str:
    """Return what to say where the source of a stream is missing; a port may have been given instead."""
    if options.port != Options().port:
        return (
            f"which source? --port is the port of the page; to listen there: mossar {command} {options.port}"
        )
    return (
        f"which source? A port, a URL, a recording, or -: mossar {command} 39539, mossar {command} take.bvh"
    )


def add_settings(
    parser: argparse.ArgumentParser, *, body_only: bool = False, with_level: bool = True
) -> None:
    """Add the options that say how to segment.

    Args:
        parser: Of the command.
        body_only: Whether the command reports the body's key frames and segments only.
        with_level: Whether the level is the user's choice.
    """
    group = parser.add_argument_group("segmentation")
    group.add_argument("--preset", choices=PRESETS, help="preset of the settings (default: default)")
    if with_level:
        group.add_argument(
            "--level", metavar="LEVEL", help="posture, motion, cluster, or a strength as a number"
        )
    group.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        type=setting,
        help="any setting, as in --set window=0.3; repeatable",
    )
    group.add_argument(
        "--rests",
        choices=[choice for choice in SETTING_CHOICES["rests"] if choice],
        help="keep: holds and rests of 0.6 s and more are separate segments; merge: the level decides",
    )
    if not body_only:
        _add_channels(group)
    group.add_argument(
        "--config",
        metavar="FILE.toml",
        help="a file with these options: long names without dashes, [settings] for --set",
    )


def _add_channels(group: Any) -> None:
    group.add_argument("--repetitions", action="store_true", help="count repetitions")
    group.add_argument("--steps", action="store_true", help="report when feet leave the ground and come down")
    group.add_argument(
        "--feet",
        metavar="SIDE=JOINT,...",
        nargs=2,
        help="for --steps: left=A,B right=C,D, if the joints of the feet are not known by name",
    )
    group.add_argument(
        "--limbs",
        metavar="NAME=JOINT,...;...",
        nargs="?",
        const="",
        help="key frames of each limb, too; arms, legs and trunk, or limbs named with their joints",
    )


def add_body(parser: argparse.ArgumentParser) -> None:
    """Add the options that say what a frame holds."""
    group = parser.add_argument_group("content of a frame")
    group.add_argument("--joints", metavar="A,B,C", type=names, help="use these joints only")
    group.add_argument("--root", metavar="JOINT", help="joint at the centre of the body")
    group.add_argument("--unit", choices=[*METRES, "auto"], help="unit of the positions (default: auto)")
    group.add_argument("--fps", metavar="HZ", type=positive, help="rate of frames without a time")
    group.add_argument(
        "--skeleton", metavar="FILE", help="skeleton of the recording, such as the .asf of an .amc"
    )
    group.add_argument("--performer", metavar="NAME", help="use this performer only")
    group.add_argument(
        "--allow-2d", action="store_true", help="accept flat poses, which are refused otherwise"
    )


def add_people(parser: argparse.ArgumentParser) -> None:
    """Add the options that give people slots instead of the sender's ids."""
    group = parser.add_argument_group("people")
    group.add_argument(
        "--people",
        metavar="N",
        type=people,
        help="follow N people as p1 to pN, independent of the tracker's ids; nearest or first: one person as p1",
    )
    group.add_argument(
        "--remember",
        metavar="SECONDS",
        type=share,
        help=f"how long an absent person keeps its slot (default: {REMEMBERED:g})",
    )


def add_messages(parser: argparse.ArgumentParser) -> None:
    """Add the options about messages on standard error."""
    group = parser.add_argument_group("messages, on standard error")
    group.add_argument("--quiet", action="store_true", help="errors only")
    group.add_argument("--verbose", action="store_true", help="everything")
    group.add_argument("--log-level", choices=LEVELS, help="level of messages (default: info)")
    group.add_argument("--log-json", action="store_true", help="one JSON object per message")


def add_output(group: argparse._ArgumentGroup, name: Literal["json", "csv"], what: str) -> None:
    """Add `--json [FILE]` or `--csv [FILE]`."""
    group.add_argument(
        f"--{name}",
        metavar="FILE",
        nargs="?",
        const=STANDARD_OUTPUT,
        help=f"{what}; to standard output without FILE",
    )


def add_plot(group: argparse._ArgumentGroup) -> None:
    """Add what pictures need, and whether files may be replaced."""
    group.add_argument("--plot", metavar="FILE", help="draw a picture: .png, .svg or .pdf")
    group.add_argument("--dark", action="store_true", help="a picture for dark pages")
    group.add_argument("--force", action="store_true", help="replace existing files")


def add_moves(group: Any) -> None:
    """Add which moves are recognised, and which are followed."""
    group.add_argument("--moves", metavar="FILE", help="recognise the moves of this file; see mossar teach")
    group.add_argument(
        "--follow",
        metavar="NAMES|all",
        type=names,
        help="follow these moves of --moves while they are made; progress, tempo, count, deviation; NAME,NAME or all",
    )


def add_part(group: argparse._ArgumentGroup) -> None:
    """Add which part of a recording is meant."""
    group.add_argument(
        "--from",
        dest="begin",
        metavar="S",
        type=seconds,
        help="begin of the part, s of the recording's clock",
    )
    group.add_argument(
        "--until",
        metavar="S",
        type=seconds,
        help="end of the part, s of the recording's clock",
    )


def add_width(group: argparse._ArgumentGroup) -> None:
    """Add how wide a picture is."""
    group.add_argument(
        "--width",
        metavar="INCHES",
        type=inches,
        help=f"of the picture (default: {WIDTH:g}); a wide one shows more",
    )


def add_stream(parser: argparse.ArgumentParser) -> None:
    """Add the options of running pipelines."""
    group = parser.add_argument_group("while running")
    group.add_argument(
        "--to", metavar="SINK", action="append", help="sink of events: a URL, a file or -; repeatable"
    )
    group.add_argument(
        "--emit",
        metavar="LIST",
        type=names,
        help="emit only these types or statuses; types (key_frame segment activity move follow pose repetition phase step stream stats), statuses (confirmed final ...) "
        "or both as key_frame.final; separated by commas",
    )
    add_moves(group)
    group.add_argument(
        "--stats", metavar="SECONDS", type=positive, help="interval of reports of counters and delays"
    )
    group.add_argument(
        "--metrics", metavar="[HOST:]PORT", type=place, help="serve counters and delays to Prometheus"
    )
    group.add_argument(
        "--control",
        metavar="URL",
        action="append",
        help="answer requests: zmq+bind://127.0.0.1:5560, or osc with an OSC source",
    )
    group.add_argument(
        "--snapshot", metavar="FILE", help="save the state to a file, from which an interrupted run continues"
    )
    group.add_argument(
        "--snapshot-every", metavar="SECONDS", type=positive, help="interval of saving the state (default: 5)"
    )
    group.add_argument(
        "--run-id",
        metavar="NAME",
        type=run_id,
        help="name of this run in its events (default: a new name for each run)",
    )
    group.add_argument("--force", action="store_true", help="replace existing files")
    group.add_argument("--seconds", metavar="S", type=positive, help="stop after this time of the stream")


def add_segmenting(parser: argparse.ArgumentParser) -> None:
    """Add what every command has that segments streams: how to segment, content, people, messages."""
    add_settings(parser)
    add_body(parser)
    add_people(parser)
    add_messages(parser)


def add_speed(parser: argparse.ArgumentParser, default: str) -> None:
    """Add `--speed`."""
    parser.add_argument(
        "--speed", metavar="X", type=speed, help=f"1 is real time; 2, 0.5, max (default: {default})"
    )


def add_page(parser: argparse.ArgumentParser) -> None:
    """Add the options of the page and the dashboard."""
    group = parser.add_argument_group("the page")
    group.add_argument(
        "--page",
        choices=("player", "dashboard"),
        help="player: large picture, one count, one verdict; dashboard: curve and sliders (default: player for a camera, and "
        "for senders with --follow, --moves or --repetitions)",
    )
    group.add_argument(
        "--port", metavar="N", type=port, help="port of the page (default: 8080, or the next free one)"
    )
    group.add_argument(
        "--host",
        metavar="ADDRESS",
        help="address of this computer for other devices, 0.0.0.0 for all; each needs a URL that is valid once "
        "(default: 127.0.0.1, this computer only)",
    )
    group.add_argument("--no-browser", action="store_true", help="print the URL and open no browser")
    group.add_argument("--dark", action="store_true", help="begin in dark colours")
