"""`mossar schema`: the JSON Schema of the events."""

import msgspec

from mossar_tools.console import Console
from mossar_tools.errors import DONE
from mossar_tools.options import Messages

DESCRIPTION = """Print the JSON Schema of the events and metas, for programs that check messages or make types.
docs/events.md explains them with examples."""
EXAMPLES = """  mossar schema > events.schema.json
  mossar schema | jq '."$defs".KeyFrameEvent.properties | keys'
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:  # noqa: ARG001 - every command gets them
    """Run the command and return the exit status."""
    from mossar_tools.event_schema import event_schema

    console.line(msgspec.json.format(msgspec.json.encode(event_schema()), indent=2).decode())
    return DONE
