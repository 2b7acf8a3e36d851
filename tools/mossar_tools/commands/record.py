"""`mossar record`: write arriving frames to a file that replay reproduces."""

from pathlib import Path
from typing import Annotated

import msgspec

from mossar_stream import FrameError, MossarError
from mossar_tools.console import LOGGER, Console
from mossar_tools.declared import Option, operand
from mossar_tools.errors import DONE, FAILED, WRONG_USAGE, UsageError
from mossar_tools.options import Body, Messages, People, SpeedOfReading
from mossar_tools.values import positive

DESCRIPTION = """Write the frames of a source to a recording. The file only grows: frames older than a second
survive a crash. Ctrl-C ends it."""
EXAMPLES = """  mossar record osc://0.0.0.0:39539 take.msk
  mossar record zmq://127.0.0.1:5556 take.msk --seconds 60 --force
  mossar record walk.bvh walk.msk --speed max            convert
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    sources: Annotated[tuple[str, ...], operand("SOURCE", "a URL, a recording, or -", 1)]
    file: Annotated[str, operand("FILE", "file to write: .msk or .jsonl")]
    force: Annotated[bool, Option("replace an existing file")] = False
    seconds: Annotated[float | None, Option("stop after this time of the stream", "S", positive)] = None
    speed: SpeedOfReading = None
    body: Body = Body()
    people: People = People()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_adapters.files import FileError
    from mossar_adapters.replay.recorder import Recorder
    from mossar_adapters.urls import open_frame_sink
    from mossar_tools.opening import source_of
    from mossar_tools.signals import stopping

    url = options.sources[0]
    if Path(options.file).suffix.lower() not in {".msk", ".jsonl"}:
        raise UsageError(f"{options.file}: recordings are written as .msk, or .jsonl to be read elsewhere")
    reading = options.body.reading(again=options.force)
    source = source_of(url, reading, options.people, options.speed)
    try:
        sink = open_frame_sink(options.file, force=options.force)
    except Exception:
        source.close()
        raise
    recorder = Recorder(source, sink, options.seconds)
    with stopping(recorder.stop) as stop:
        try:
            for frames, seconds in recorder.run():
                console.status(f"{url} · {frames} frames, {seconds:.1f} s")
            failure = recorder.error
        except MossarError as error:  # of the file that is written
            failure = error
    console.clear()
    if recorder.frames:
        LOGGER.info("%s: %d frames", options.file, recorder.frames)
    elif failure is None:
        LOGGER.warning("no frame came; %s was not written", options.file)
    if failure is not None:
        LOGGER.error("%s", failure)
        return stop.status or (WRONG_USAGE if isinstance(failure, FileError | FrameError) else FAILED)
    return stop.status or DONE
