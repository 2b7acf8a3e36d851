"""Event schema: the JSON Schema of everything that `mossar run` puts out, made from the records themselves."""

import inspect
from typing import Any, get_args

import msgspec

from mossar_adapters.maps.frame_maps import MetaMap
from mossar_adapters.maps.states import StateMap
from mossar_stream import Event, Settings


def event_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of one event or meta: a line of JSON, a WebSocket message, a ZeroMQ map."""
    schema = msgspec.json.schema(Event)
    for record in _MAPS:
        _add_map(schema, record)
    for event in get_args(Event):
        definition = schema["$defs"][event.__name__]
        summary, fields = _explained(event)
        definition["description"] = summary
        # Fields with defaults are always sent, too, but for those of records that leave them out.
        optional = _left_out(event)
        definition["required"] = [name for name in definition["properties"] if name not in optional]
        for name, text in fields.items():
            definition["properties"][name]["description"] = text
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "An event of mossar-stream, or the description of a performer",
        **schema,
    }


# Further messages: their type, and the fields that may be absent.
_MAPS: dict[type, tuple[str, tuple[str, ...]]] = {
    MetaMap: ("meta", ("fps", "settings", "run", "version")),
    StateMap: ("state", ("level", "run")),
}


def _add_map(schema: dict[str, Any], record: type) -> None:
    """Add the other messages of WebSocket and ZeroMQ: metas, and the states of performers."""
    name, may_be_absent = _MAPS[record]
    place = f"#/$defs/{record.__name__}"
    definition = msgspec.to_builtins(msgspec.json.schema(record))["$defs"][record.__name__]
    definition["description"], fields = _explained(record)
    for field, text in fields.items():
        definition["properties"][field]["description"] = text
    definition["properties"]["type"] = {"const": name, "description": fields["type"]}
    for field in definition["properties"].values():
        if field.get("default") in ((), {}):
            del field["default"]
    if "settings" in definition["properties"]:
        settings = msgspec.json.schema(Settings)["$defs"]
        settings["Settings"]["description"] = _explained(Settings)[0]
        schema["$defs"].update(settings)
        definition["properties"]["settings"]["$ref"] = "#/$defs/Settings"
    definition["required"] = [field for field in definition["properties"] if field not in may_be_absent]
    schema["$defs"][record.__name__] = definition
    schema["anyOf"].append({"$ref": place})
    schema["discriminator"]["mapping"][name] = place


def _left_out(event: type[msgspec.Struct]) -> list[str]:
    """Return the fields that are not sent if they are empty."""
    if not event.__struct_config__.omit_defaults:
        return []
    fields = msgspec.structs.fields(event)
    return [field.encode_name for field in fields if field.default is not msgspec.NODEFAULT]


def _explained(event: type) -> tuple[str, dict[str, str]]:
    """Return the first line of a record's docstring, and the text of each field."""
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
