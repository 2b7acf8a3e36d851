"""Outputs: where results go, as JSON, as a table or as a picture; the same for every command."""

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Self

import msgspec

from mossar_adapters.files.output import OutputError
from mossar_adapters.files.replacing import Draft
from mossar_adapters.table_text import csv_text
from mossar_tools.console import Console, is_terminal
from mossar_tools.declared import values_of
from mossar_tools.errors import UsageError
from mossar_tools.options import STANDARD_OUTPUT

Rows = Sequence[Mapping[str, Any]]
# Which option writes files of an ending; empty if none does.
_ENDINGS = {".json": "--json", ".csv": "--csv", ".png": "--plot", ".xlsx": "", ".xls": "", ".ods": ""}


class Outputs(NamedTuple):
    """The outputs besides a table to read.

    Args:
        json: File for one JSON object, `-` for standard output, None if it is not wanted.
        csv: The same for a table with a heading.
        picture: File to be drawn.
        exports: Files for annotation programs.
        clips: Folder for a recording of each segment.
        curves: File for the angles of every frame.
    """

    json: str | None
    csv: str | None
    picture: Path | None
    exports: tuple[Path, ...] = ()
    clips: Path | None = None
    curves: Path | None = None

    @classmethod
    def of(cls, options: msgspec.Struct) -> Self:
        """Return the outputs of the options, after a check that they can be written: before the work, not after it.

        Raises:
            MossarError: If something cannot be written, or is there already and `--force` is not given.
        """
        given = values_of(options)
        json, csv, plot, curves, cut = map(given.get, ("json", "csv", "plot", "curves", "cut"))
        export, sources, force = given.get("export", ()), given.get("sources", ()), given["force"]
        if json == csv == STANDARD_OUTPUT:
            raise UsageError(
                "--json and --csv cannot both go to standard output; name a file for one of them"
            )
        picture = None
        if plot is not None:
            from mossar_tools.figures import check_picture

            picture = check_picture(plot)
        _check_ending("--json", json)
        _check_ending("--csv", csv)
        for name in (json, csv, plot, curves, *export):
            if name is not None and name != STANDARD_OUTPUT:
                _check(Path(name), force=force)
        exports = tuple(Path(name) for name in export)
        for path in exports:
            from mossar_adapters.annotations.c3d import check_source, is_c3d
            from mossar_adapters.annotations.label_studio import is_label_studio
            from mossar_adapters.annotations.writing import check_annotations

            if is_c3d(path):
                check_source(sources[0] if sources else "", path)
            elif not is_label_studio(path):
                check_annotations(path)
        clips = None
        if cut is not None:
            from mossar_adapters.files.clips import check_clips

            clips = Path(cut)
            check_clips(clips, sources, replace=force)
        if curves is not None and Path(curves).suffix.lower() != ".csv":
            from mossar_tools.figures import check_picture

            check_picture(curves)
        return cls(json, csv, picture, exports, clips, None if curves is None else Path(curves))

    @property
    def piped(self) -> bool:
        """Whether standard output is taken, so that nothing else may be written there."""
        return STANDARD_OUTPUT in {self.json, self.csv}

    def reading(self, console: Console, *, quiet: bool) -> Callable[[str], None] | None:
        """Return a writer of readable lines; None if unwanted, or if standard output is taken and no terminal is left."""
        if quiet:
            return None
        if not self.piped:
            return console.line
        return console.say if is_terminal(console.err) else None

    def write(self, console: Console, report: Mapping[str, Any], rows: Rows, lines: Iterable[str]) -> None:
        """Write the JSON object and the table, if they are wanted, and lines to read unless standard output is taken."""
        self.write_json(report, console)
        self.write_csv(rows, console)
        if not self.piped:
            for line in lines:
                console.line(line)

    def write_json(self, value: Mapping[str, Any], console: Console) -> None:
        """Write one JSON object, if that is wanted."""
        with self.json_lines(console) as write:
            write(value)

    @contextlib.contextmanager
    def json_lines(self, console: Console) -> Iterator[Callable[[Mapping[str, Any]], None]]:
        """Yield a writer of one JSON object a line, each at once; it writes nothing if that is not wanted."""
        with _lines(self.json, console) as write:
            yield lambda value: write(msgspec.json.encode(value).decode() + "\n")

    @contextlib.contextmanager
    def csv_rows(self, columns: Sequence[str], console: Console) -> Iterator[Callable[[Rows], None]]:
        """Yield a writer of rows of a table, each at once; it writes nothing if that is not wanted."""
        with _lines(self.csv, console) as write:
            write(_csv_text(columns, [dict(zip(columns, columns, strict=True))]))
            yield lambda rows: write(_csv_text(columns, rows))

    def write_csv(self, rows: Rows, console: Console, columns: Sequence[str] | None = None) -> None:
        """Write a table, if that is wanted.

        Args:
            rows: Each has all columns.
            console: Where standard output is.
            columns: Its heading; that of the first row if it is None.
        """
        columns = columns or (list(rows[0]) if rows else [])
        with self.csv_rows(columns, console) as write:
            write(rows)


def _check(path: Path, *, force: bool) -> None:
    if path.is_dir():
        raise UsageError(f"{path}: this is a folder; name a file")
    if not path.parent.is_dir():
        raise UsageError(f"{path}: there is no folder {path.parent}")
    if path.exists() and not force:
        raise UsageError(f"{path}: there is a file already; --force replaces it")


def _csv_text(columns: Sequence[str], rows: Rows) -> str:
    return csv_text([row.get(column, "") for column in columns] for row in rows)


@contextlib.contextmanager
def _lines(place: str | None, console: Console) -> Iterator[Callable[[str], None]]:
    """Yield a writer of whole lines to a place, to nowhere if it is None."""
    if place is None:
        yield lambda _: None
    elif place == STANDARD_OUTPUT:
        yield lambda text: console.line(text.rstrip("\n")) if text else None
    else:
        with _file_errors(place):
            draft = Draft(place)
            file = draft.path.open("w", encoding="utf-8", newline="")

        def write(text: str) -> None:
            with _file_errors(place):
                file.write(text)

        try:
            yield write
            with _file_errors(place):
                file.close()
        except BaseException:
            with contextlib.suppress(OSError):
                file.close()
            with _file_errors(place):
                # The part of a new file is kept, as of a long batch that was interrupted.
                draft.drop() if draft.replaces else draft.put()
            raise
        with _file_errors(place):
            draft.put()
        console.say(f"written: {place}")


def _check_ending(option: str, name: str | None) -> None:
    """Refuse a name that promises another format: a spreadsheet refuses such a file, too."""
    suffix = Path(name or "").suffix.lower()
    if suffix in _ENDINGS and _ENDINGS[suffix] != option:
        kind = option.removeprefix("--")
        meant = _ENDINGS[suffix] or f"{option} {Path(name or '').with_suffix(f'.{kind}')}"
        raise UsageError(f"{option} {name}: {option} writes {kind.upper()} - did you mean {meant}?")


@contextlib.contextmanager
def _file_errors(place: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(f"{place}: cannot be written: {error.strerror or error}") from None
