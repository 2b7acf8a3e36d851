"""Job: the description of a job of `mossar flink`, read from a TOML file.

    name = "mossar"
    parallelism = 1

    [source]                      # one of these
    files = "frames"              # a file or folder of records, one JSON object per line
    # kafka = { servers = "broker:9092", topic = "frames", group = "mossar" }

    [to]                          # one of these
    live = "-"                    # any sink of `mossar run`, at once: at least once
    # files = "events"            # a folder of JSON lines, whole at each checkpoint: exactly once
    # kafka = { servers = "broker:9092", topic = "events", guarantee = "at-least-once" }

    [segmenter]
    preset = "default"
    level = "motion"
    settings = { window = 0.25 }  # limbs = true, repetitions = true
    # moves = "moves.json"        # recognise these; see mossar teach
    # follow = ["squat"]          # and follow these of them while they are made; or "all"

    [takes]
    idle = 5.0                    # s of wall time without records that end a take; 0: only the frames' times do
    forget = 3600.0               # s until a performer is forgotten

    [checkpoints]
    folder = "checkpoints"
    seconds = 10.0
    resume = true                 # go on from the latest one in the folder

    [flink]                       # options of the engine, as they are
    "state.backend.type" = "rocksdb"

Paths are relative to the file's folder; addresses such as s3://bucket/events stay as they are.
"""

from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import msgspec

from mossar_adapters.address import parse_url
from mossar_adapters.toml_file import read_toml
from mossar_adapters.urls import SCHEMES
from mossar_stream import Moves, MovesError, Settings, SettingsError

Text = Annotated[str, msgspec.Meta(min_length=1)]
Seconds = Annotated[float, msgspec.Meta(gt=0, le=1e7)]


class _Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of the file."""


class KafkaSource(_Part, frozen=True):
    """A topic of records, keyed by performer.

    Args:
        servers: HOST:PORT, several with commas.
        topic: Its name.
        group: Consumer group.
        begin: The offset without a checkpoint; `committed` is the group's last one, else the earliest.
        properties: Of the client, as they are.
    """

    servers: Text
    topic: Text
    group: Text = "mossar"
    begin: Literal["committed", "earliest", "latest"] = "committed"
    properties: dict[str, str] = {}


class KafkaTarget(_Part, frozen=True):
    """A topic of events, keyed by performer.

    Args:
        servers: HOST:PORT, several with commas.
        topic: Its name.
        guarantee: `at-least-once` sends at once, `exactly-once` in transactions that end at checkpoints.
        properties: Of the client, as they are.
    """

    servers: Text
    topic: Text
    guarantee: Literal["at-least-once", "exactly-once"] = "at-least-once"
    properties: dict[str, str] = {}


class Source(_Part, frozen=True):
    """The source of records; one of these."""

    files: Text | None = None
    kafka: KafkaSource | None = None


class Target(_Part, frozen=True):
    """The target of events; one of these."""

    live: Text | None = None
    files: Text | None = None
    kafka: KafkaTarget | None = None


class Segmenting(_Part, frozen=True):
    """Settings of the segmenters."""

    preset: Literal["paper", "default", "game"] = "default"
    level: str | float | None = None
    settings: dict[str, Any] = {}
    moves: Text | None = None
    follow: tuple[Text, ...] | Literal["all"] = ()

    def build(self) -> Settings:
        """Return the settings.

        Raises:
            SettingsError: If one is unknown, illegal, or of no use to a stream.
        """
        level = {} if self.level is None else {"level": self.level}
        settings = Settings.build(self.preset, {**self.settings, **level})
        if settings.range == "file":
            raise SettingsError("setting range=file needs a whole recording; a stream takes running")
        return settings

    def read_moves(self) -> Moves | None:
        """Return the moves to recognise, if a file of them is named; it is read where the job is started.

        Raises:
            SettingsError: If it cannot be read, or is none.
        """
        if self.moves is None:
            return None
        try:
            return Moves.load(self.moves)
        except OSError as error:
            raise SettingsError(f"segmenter.moves: {self.moves}: cannot be read: {error.strerror}") from None
        except MovesError as error:
            raise SettingsError(f"segmenter.moves: {self.moves}: {error}") from None

    def followed(self, moves: Moves | None) -> tuple[str, ...] | bool:
        """Return the moves that are followed.

        Raises:
            SettingsError: If there are no moves, or none of a name.
        """
        if self.follow and moves is None:
            raise SettingsError(
                "segmenter.follow needs segmenter.moves: the file has the moves that are followed"
            )
        if moves is None or self.follow == "all":
            return self.follow == "all"
        for name in self.follow:
            if name not in moves.reported:
                known = ", ".join(moves.reported) or "none"
                raise SettingsError(
                    f"segmenter.follow: {self.moves} has no move {name[:80]}; there are {known}"
                )
        return tuple(self.follow)


class Takes(_Part, frozen=True):
    """Times after which takes end and performers are forgotten, s of wall time."""

    idle: Annotated[float, msgspec.Meta(ge=0, le=1e7)] = 5.0
    forget: Seconds = 3600.0


class Checkpoints(_Part, frozen=True):
    """Folder and interval of the checkpoints."""

    folder: Text = "checkpoints"
    seconds: Annotated[float, msgspec.Meta(ge=0.1, le=86400)] = 10.0
    resume: bool = True


class Job(_Part, frozen=True):
    """A whole job; fields as in the module's example."""

    source: Source
    to: Target = Target(live="-")
    name: Text = "mossar"
    parallelism: Annotated[int, msgspec.Meta(ge=1, le=32768)] = 1
    segmenter: Segmenting = Segmenting()
    takes: Takes = Takes()
    checkpoints: Checkpoints = Checkpoints()
    flink: dict[str, str | bool | int | float] = {}


_TABLES: dict[str, type[_Part]] = {
    "source": Source,
    "source.kafka": KafkaSource,
    "to": Target,
    "to.kafka": KafkaTarget,
    "segmenter": Segmenting,
    "takes": Takes,
    "checkpoints": Checkpoints,
}


def read_job(path: Path) -> Job:
    """Return the job in a file, with absolute places.

    Raises:
        SettingsError: If it cannot be read, or something in it is unknown or impossible; one line names it.
    """
    content = read_toml(path, "job", SettingsError)
    try:
        job = _placed(msgspec.convert(content, Job), path.absolute().parent)
        _check(job)
    except msgspec.ValidationError as error:
        raise SettingsError(f"{path}: {_explained(str(error))}") from None
    except SettingsError as error:
        raise SettingsError(f"{path}: {error}") from None
    return job


def _placed(job: Job, folder: Path) -> Job:
    """Return a job with absolute places."""
    replace, moves = msgspec.structs.replace, job.segmenter.moves
    return replace(
        job,
        source=replace(job.source, files=_place(folder, job.source.files)),
        to=replace(job.to, files=_place(folder, job.to.files)),
        segmenter=replace(job.segmenter, moves=None if moves is None else str(folder / moves)),
        checkpoints=replace(job.checkpoints, folder=_place(folder, job.checkpoints.folder)),
    )


def _check(job: Job) -> None:
    _check_one("source", job.source)
    _check_one("to", job.to)
    job.segmenter.build()
    job.segmenter.followed(job.segmenter.read_moves())
    if job.takes.idle >= job.takes.forget:
        raise SettingsError("takes.forget must be longer than takes.idle")
    if job.to.live is not None:
        _check_live(job.to.live)


def _check_live(url: str) -> None:
    scheme = parse_url(url).scheme
    if scheme == "file":
        raise SettingsError(
            f'to.live = "{url}": a file would begin again after a failure; use files = "FOLDER"'
        )
    known = [name for row in SCHEMES if row.sink is not None for name in row.names if name != "file"]
    if scheme not in known:
        raise SettingsError(f'to.live = "{url}": there is no sink {scheme}:; there are {" ".join(known)}')


def _check_one(name: str, table: Source | Target) -> None:
    given = [field for field in table.__struct_fields__ if getattr(table, field) is not None]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        raise SettingsError(f"[{name}] takes one of {', '.join(table.__struct_fields__)}; there is {found}")


def _explained(message: str) -> str:
    """Turn msgspec's message into one that begins with the place in the file and names the legal values."""
    text, _, place = message.partition(" - at `")
    keys = place.rstrip("`").removeprefix("$").removeprefix(".")
    if text.startswith("Object contains unknown field"):
        there = ", ".join(_TABLES.get(keys, Job).__struct_fields__)
        text = f"there is no key {text.rpartition(' ')[2]}; there are {there}"
    elif text.startswith("Object missing required field"):
        text = f"there must be a key {text.rpartition(' ')[2]}"
    elif text.startswith("Invalid enum value"):
        table, _, field = keys.rpartition(".")
        legal = ", ".join(get_args(_TABLES[table].__annotations__[field]))
        text = f"there is no {text.rpartition(' ')[2]}; there are {legal}"
    else:
        text = text[0].lower() + text[1:]
    return f"{keys}: {text}" if keys else text


def _place(folder: Path, path: str | None) -> str | None:
    """Return a path of the file as a URI."""
    if path is None or "://" in path:
        return path
    return (folder / path).resolve().as_uri()
