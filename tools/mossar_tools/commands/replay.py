"""`mossar replay`: send a recording out as a live stream of frames."""

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec

from mossar_adapters.abilities import Drops, offered
from mossar_adapters.address import parse_url
from mossar_stream import FrameError, MossarError
from mossar_tools.console import LOGGER, Console
from mossar_tools.declared import Option, operand
from mossar_tools.errors import DONE, FAILED, UsageError
from mossar_tools.options import Body, Messages, Speed

if TYPE_CHECKING:
    from mossar_adapters.files import JointMotion
    from mossar_adapters.files.options import ReadOptions
    from mossar_adapters.sink import FrameSink

DESCRIPTION = """Send a recording as a live stream, each frame at its own time. VMC receivers get rotations, too, if the
recording has them."""
EXAMPLES = """  mossar replay walk.bvh --to 'osc://127.0.0.1:39539?profile=vmc'
  mossar replay take.msk --to zmq+bind://127.0.0.1:5556 --speed 2
  mossar replay 86_01.amc --to 'osc://127.0.0.1:7110?profile=osceleton' --loop
  mossar replay 'demo:?seconds=10' --to - > frames.jsonl
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    file: Annotated[str, operand("FILE", "a recording, or demo:")]
    to: Annotated[
        tuple[str, ...],
        Option(
            "sink of frames: osc://, zmq+bind://, - or a file; repeatable",
            "SINK",
            repeatable=True,
        ),
    ] = ()
    speed: Speed = None
    loop: Annotated[bool, Option("repeat until Ctrl-C")] = False
    force: Annotated[bool, Option("replace an existing file")] = False
    body: Body = Body()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_adapters.files import FileError
    from mossar_adapters.live import OutputClosedError
    from mossar_adapters.replay.replaying import Replay
    from mossar_adapters.urls import open_frame_sink
    from mossar_tools.opening import source_of

    if not options.to:
        raise UsageError("where to? Name a sink, as in --to osc://127.0.0.1:39539?profile=vmc")
    scheme = parse_url(options.file).scheme
    if scheme not in {"file", "demo"}:
        raise UsageError(f"{options.file}: mossar replay sends recordings and demo:, not live streams")
    reading = options.body.reading(again=options.force)
    with contextlib.ExitStack() as opened:
        source = source_of(options.file, reading, speed=options.speed or 1.0, loop=options.loop)
        opened.callback(source.close)
        sinks: list[FrameSink] = []
        for url in options.to:
            sinks.append(open_frame_sink(url, force=options.force))
            opened.callback(sinks[-1].close)
        motion = _motion(options.file, reading) if scheme == "file" else None
        try:
            for seconds in Replay(source, sinks, motion).run():
                console.status(f"{source.name} · {seconds:.1f} s sent")
            for sink in sinks:
                sink.close()
        except OutputClosedError:
            raise BrokenPipeError from None
        except (FileError, FrameError):  # the recording is damaged, or lacks a joint of the options
            raise
        except MossarError as error:  # a sink failed
            LOGGER.error("%s", error)
            return FAILED
    for sink in sinks:
        if (dropping := offered(sink, Drops)) is not None and dropping.dropped:
            LOGGER.warning("%s: %d messages were not taken by the system", sink.name, dropping.dropped)
    return DONE


def _motion(file: str, reading: "ReadOptions") -> "JointMotion | None":
    """Return the rotations of a recording, None if it has none."""
    from mossar_adapters.files import open_motion
    from mossar_adapters.files.registry import format_of

    path = Path(parse_url(file).path)
    return open_motion(path, reading) if format_of(path).motion else None
