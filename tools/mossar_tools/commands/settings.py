"""`mossar settings`: the value of every setting, its source, and its effect."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any

import msgspec

from mossar_stream import SETTING_METAS, Settings
from mossar_tools.console import Console
from mossar_tools.declared import Option, Section
from mossar_tools.errors import DONE
from mossar_tools.options import Messages, Segmenting, output
from mossar_tools.outputs import Outputs

DESCRIPTION = """Print the value of the settings to begin with, or of --all: the unit, where the value comes from (default,
preset, the level, or you), and its effect. All commands that segment take any setting as --set NAME=VALUE."""
EXAMPLES = """  mossar settings
  mossar settings --all
  mossar settings --level cluster --preset game --set window=0.3
  mossar settings --json | jq '.settings.window.value'
"""

FIRST = ("level", "rests", "sig_threshold", "range_floor", "remerge_seconds")  # for a first look
LONG = 20  # characters of legal values that are not repeated in the table
# Other settings that set a value left to the bundle; the first that is given counts.
FOLLOWED = {
    "range_floor": ("window",),
    "location": ("similarity",),
    "rate_limit": ("range",),
    "rests": ("similarity",),
    "tempo": ("remerge_seconds", "similarity"),
}


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    segmentation: Segmenting = Segmenting()
    all: Annotated[bool, Option("all settings, experts' ones, too")] = False
    json: Annotated[str | None, Section("output"), output("the settings as one JSON object")] = None
    csv: Annotated[str | None, output("a row for each setting")] = None
    force: Annotated[bool, Option("replace existing files")] = False
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    outputs = Outputs.of(options)
    segmentation = options.segmentation
    found = explained(segmentation)
    outputs.write_json({"v": 1, "preset": segmentation.preset, "settings": found}, console)
    rows = _rows(found)
    outputs.write_csv(rows, console)
    if not outputs.piped:
        for line in _lines(options, rows, console):
            console.line(line)
    return DONE


def _lines(options: Options, rows: Sequence[Mapping[str, Any]], console: Console) -> Iterator[str]:
    """Yield the table of the first settings and those that were set, or of all."""
    set_here = {name.partition(".")[0] for name in options.segmentation.set}
    first = [row for row in rows if row["name"].partition(".")[0] in {*FIRST, *set_here}]
    first.sort(key=lambda row: FIRST.index(row["name"]) if row["name"] in FIRST else len(FIRST))
    yield from _table(rows if options.all else first, console)
    if not options.all:
        yield ""
        yield from console.fold(
            f"{len(rows) - len(first)} more: mossar settings --all. To change one: --set NAME=VALUE, of every command."
        )


def _rows(found: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each setting, and for each part of those that have parts, as `--set` names them."""
    rows = []
    for name, row in found.items():
        parts = row["value"] if isinstance(row["value"], dict) else {"": row["value"]}
        for part, value in parts.items():
            rows.append({"name": f"{name}.{part}".rstrip("."), **row, "value": _shown(value)})
    return rows


def _table(rows: Sequence[Mapping[str, Any]], console: Console) -> Iterator[str]:
    """Yield a line for each setting; if it does not fit the terminal, its effect follows on separate lines."""
    columns = {"name": "setting", "value": "value", "unit": "unit", "from": "from", "legal": "legal"}
    shown = [{**row, "legal": row["legal"] if len(row["legal"]) < LONG else "see the right"} for row in rows]
    widths = {key: max(len(title), *(len(row[key]) for row in shown)) for key, title in columns.items()}
    for row in ({**columns, "effect": "effect"}, *shown):
        line = "  ".join(f"{row[key]:<{width}}" for key, width in widths.items())
        if console.room() is None or len(line) + 2 + max(len(own["effect"]) for own in shown) <= (
            console.room() or 0
        ):
            yield f"{line}  {row['effect']}"
            continue
        brief = f"{row['name']:<{widths['name']}}  {row['value']} {row['unit']}".rstrip()
        yield from console.fold(brief if row["name"] != "setting" else "setting, value, effect")
        if row["name"] != "setting":
            yield from console.fold(f"    {row['effect']}", "")


def explained(segmentation: Segmenting) -> dict[str, dict[str, Any]]:
    """Return value, unit, legal values, source of the value, and effect of each setting."""
    chosen = segmentation.settings()
    resolved = chosen.resolved()
    found = {}
    for name, meta in SETTING_METAS.items():
        found[name] = {
            "value": msgspec.to_builtins(getattr(resolved, name)),
            "unit": meta.unit,
            "from": _origin(name, segmentation, chosen),
            "legal": meta.written,
            "effect": meta.effect,
        }
    return found


def _origin(name: str, segmentation: Segmenting, chosen: Settings) -> str:
    if name in {full.partition(".")[0] for full in segmentation.set}:
        return "you"
    given = {
        "level": segmentation.level,
        "repetitions": segmentation.repetitions or None,
        "limbs": segmentation.limbs,
        "rests": segmentation.rests,
    }
    if given.get(name) is not None:
        return "you"
    if getattr(chosen, name) is None and getattr(chosen.resolved(), name) is not None:
        return _followed(name, chosen) or f"level {chosen.bundle}"
    preset, default = Settings.build(segmentation.preset), Settings()
    return "default" if getattr(preset, name) == getattr(default, name) else f"preset {segmentation.preset}"


def _followed(name: str, chosen: Settings) -> str:
    """Return the setting that sets a value left to the bundle; empty if none does."""
    own = Settings(level=chosen.level).bundle_values()[name]
    if chosen.bundle_values()[name] == own:
        return ""
    leader = next(name for name in FOLLOWED[name] if getattr(chosen, name) is not None)
    return f"{leader}={_shown(getattr(chosen, leader))}"


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else "-" if value is None else str(value)
