"""Event schema: the JSON Schema of everything that `mossar run` puts out, made from the records themselves."""

import inspect
from typing import Any

import msgspec

from mossar_adapters.maps.frame_maps import MetaMap
from mossar_stream import (
    Event,
    KeyFrameEvent,
    MoveEvent,
    PhaseEvent,
    RepetitionEvent,
    SegmentEvent,
    StatsEvent,
    StreamEvent,
)

_EVENTS = (KeyFrameEvent, SegmentEvent, RepetitionEvent, PhaseEvent, MoveEvent, StreamEvent, StatsEvent)
_OF_LIMBS = ("channel", "limb")


def event_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of one event or meta: a line of JSON, a WebSocket message, a ZeroMQ map."""
    schema = msgspec.json.schema(Event)
    _add_meta(schema)
    for event in _EVENTS:
        definition = schema["$defs"][event.__name__]
        summary, fields = _explained(event)
        definition["description"] = summary
        # Fields with defaults are always sent, too, but for those of records that leave them out.
        optional = _OF_LIMBS if event.__struct_config__.omit_defaults else ()
        definition["required"] = [name for name in definition["properties"] if name not in optional]
        for name, text in fields.items():
            definition["properties"][name]["description"] = text
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "An event of mossar-stream, or what is known of a performer",
        **schema,
    }


_META = MetaMap.__name__
_MAY_BE_ABSENT = ("fps", "settings", "version")


def _add_meta(schema: dict[str, Any]) -> None:
    """Add the meta, which WebSocket and ZeroMQ send before a performer's events."""
    place = f"#/$defs/{_META}"
    definition = msgspec.to_builtins(msgspec.json.schema(MetaMap))["$defs"][_META]
    definition["description"], fields = _explained(MetaMap)
    for name, text in fields.items():
        definition["properties"][name]["description"] = text
    definition["properties"]["type"] = {"const": "meta", "description": fields["type"]}
    definition["properties"]["parents"].pop("default")
    definition["required"] = [name for name in definition["properties"] if name not in _MAY_BE_ABSENT]
    schema["$defs"][_META] = definition
    schema["anyOf"].append({"$ref": place})
    schema["discriminator"]["mapping"]["meta"] = place


def _explained(event: type) -> tuple[str, dict[str, str]]:
    """Return the first line of a record's docstring, and what it says of each field."""
    text = inspect.getdoc(event) or ""
    fields: dict[str, str] = {}
    name = ""
    for line in text.partition("Args:\n")[2].splitlines():
        if line.startswith("    ") and line[4] != " ":
            name, _, rest = line.strip().partition(": ")
            fields[name] = rest
        elif line.strip() and name:
            fields[name] += " " + line.strip()
    return text.partition("\n")[0], fields
