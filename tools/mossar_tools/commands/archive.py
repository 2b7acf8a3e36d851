"""`mossar archive`: a folder or bucket of recordings into Parquet tables."""

import time
from typing import Annotated

import msgspec

from mossar_tools.console import LOGGER, Console
from mossar_tools.declared import Option, operand
from mossar_tools.errors import DONE
from mossar_tools.options import Body, Followed, Messages, MovesFile, Segmenting

DESCRIPTION = """Segment all recordings of a folder or bucket on Ray Data, offline, with the range of each whole file:
tables of key frames with their strengths, of segments, moves, performances of followed moves and repetitions, of recordings, and of the files that could
not be read."""
EXAMPLES = """  mossar archive recordings tables
  mossar archive recordings tables --resume          after an interruption, or with new recordings
  mossar archive recordings tables --moves moves.json --limbs
  mossar archive s3://bucket/mocap s3://bucket/tables --level cluster
  python -c "import pandas; print(pandas.read_parquet('tables/segments'))"
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    file: Annotated[str, operand("IN", "a folder, or a URL such as s3://bucket/folder")]
    target: Annotated[str, operand("OUT", "folder or URL of the tables")]
    resume: Annotated[bool, Option("continue an interrupted job")] = False
    segmentation: Segmenting = Segmenting()
    moves: MovesFile = None
    follow: Followed = ()
    body: Body = Body()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_adapters.extras import needed
    from mossar_tools.moves_file import moves_to_follow

    settings = options.segmentation.settings(options.file, range="file")
    moves, follow = moves_to_follow(options.moves, options.follow)
    needed("ray", "archive", "mossar archive")
    needed("pyarrow", "archive", "mossar archive")
    from mossar_adapters.archive.job import Progress, run

    def on_progress(progress: Progress) -> None:
        share = (progress.done + progress.broken) / progress.recordings
        console.status(
            f"{progress.done + progress.broken} of {progress.recordings} recordings ({share:.0%}), "
            f"{progress.broken} broken, {progress.frames / (time.monotonic() - began):.0f} frames/s"
        )

    began = time.monotonic()
    reading = options.body.reading()
    found = run(
        options.file,
        options.target,
        settings,
        reading,
        moves,
        follow,
        resume=options.resume,
        on_progress=on_progress,
    )
    seconds = time.monotonic() - began
    console.clear()
    passed_over = f"; {found.passed_over} other files skipped" if found.passed_over else ""
    LOGGER.info(
        "%s: %d of %d recordings segmented, %d broken (table errors)%s; %d frames in %.0f s",
        options.target,
        found.done,
        found.recordings,
        found.broken,
        passed_over,
        found.frames,
        seconds,
    )
    return DONE
