"""`mossar record`: write arriving frames to a file that replay reproduces."""

import argparse
from pathlib import Path

from mossar_stream import FrameError, MossarError
from mossar_tools.console import LOGGER, Console
from mossar_tools.errors import DONE, FAILED, WRONG_USAGE, UsageError
from mossar_tools.options import Options, add_body, add_messages, add_people, add_speed
from mossar_tools.values import positive

DESCRIPTION = """Write the frames of a source to a recording. The file only grows: frames older than a second
survive a crash. Ctrl-C ends it."""
EXAMPLES = """  mossar record osc://0.0.0.0:39539 take.msk
  mossar record zmq://127.0.0.1:5556 take.msk --seconds 60 --force
  mossar record walk.bvh walk.msk --speed max            convert
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("sources", metavar="SOURCE", nargs=1, help="a URL, a recording, or -")
    parser.add_argument("file", metavar="FILE", help="file to write: .msk or .jsonl")
    parser.add_argument("--force", action="store_true", help="replace an existing file")
    parser.add_argument("--seconds", metavar="S", type=positive, help="stop after this time of the stream")
    add_speed(parser, "max for recordings, 1 for demo:")
    add_body(parser)
    add_people(parser)
    add_messages(parser)


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
    source = source_of(url, options)
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
