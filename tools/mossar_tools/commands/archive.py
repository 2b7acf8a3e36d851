"""`mossar archive`: a folder or bucket of recordings into Parquet tables."""

import argparse
import time

from mossar_tools.console import LOGGER, Console
from mossar_tools.errors import DONE
from mossar_tools.options import Options, add_body, add_messages, add_moves, add_settings

DESCRIPTION = """Segment all recordings of a folder or bucket on Ray Data, offline, with the range of each whole file:
tables of key frames with their strengths, of segments, moves, performances of followed moves and repetitions, of recordings, and of the files that could
not be read."""
EXAMPLES = """  mossar archive recordings tables
  mossar archive recordings tables --resume          after an interruption, or with new recordings
  mossar archive recordings tables --moves moves.json --limbs
  mossar archive s3://bucket/mocap s3://bucket/tables --level cluster
  python -c "import pandas; print(pandas.read_parquet('tables/segments'))"
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("file", metavar="IN", help="a folder, or a URL such as s3://bucket/folder")
    parser.add_argument("target", metavar="OUT", help="folder or URL of the tables")
    parser.add_argument("--resume", action="store_true", help="continue an interrupted job")
    add_settings(parser)
    add_moves(parser)
    add_body(parser)
    add_messages(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_adapters.extras import needed
    from mossar_tools.moves_file import moves_to_follow

    settings = options.settings(range="file")
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
    reading = options.reading()
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
