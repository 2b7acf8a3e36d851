"""`mossar segment`: a whole recording, offline."""

import argparse
import csv
import io
from typing import TYPE_CHECKING

import msgspec

from mossar_tools.console import Console
from mossar_tools.errors import DONE, UsageError
from mossar_tools.options import WIDTH, Options, add_body, add_messages, add_settings
from mossar_tools.values import inches, seconds
from mossar_tools.values import whole as whole_number

if TYPE_CHECKING:
    from mossar_stream.recording import Segmentation

DESCRIPTION = """Segment a whole recording, offline, with the range of the whole file: key frames, their hierarchy,
segments at a level. Without an option a table for people."""
EXAMPLES = """  mossar segment walk.bvh
  mossar segment walk.bvh --plot walk.png              also .svg and .pdf
  mossar segment long.bvh --plot part.png --from 600 --to 660 --width 16
  mossar segment 86_01.amc --level cluster --csv > segments.csv
  mossar segment take.c3d --keep 12 --json | jq '.segments[].state'
  mossar segment demo:?seed=3 --plot demo.pdf --dark
"""

COLUMNS = ("start", "end", "duration", "state", "strength")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("file", metavar="FILE", help="a recording, or demo:")
    group = parser.add_argument_group("what to put out")
    form = group.add_mutually_exclusive_group()
    form.add_argument(
        "--json", action="store_true", help="all key frames with their strengths, and the segments"
    )
    form.add_argument(
        "--csv", action="store_true", help="start, end, duration (s), state, strength of segments"
    )
    group.add_argument("--plot", metavar="FILE", help="draw a picture: .png, .svg or .pdf")
    group.add_argument("--dark", action="store_true", help="a picture for dark pages")
    group.add_argument(
        "--from",
        dest="plot_from",
        metavar="S",
        type=seconds,
        help="begin the picture here, s of the recording",
    )
    group.add_argument("--to", dest="plot_to", metavar="S", type=seconds, help="end the picture here")
    group.add_argument(
        "--width", metavar="INCHES", type=inches, help="of the picture (default: 11); a wide one shows more"
    )
    group.add_argument("--keep", metavar="K", type=whole_number, help="keep the K strongest key frames")
    add_settings(parser)
    add_body(parser)
    add_messages(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    settings = options.settings(range="file")
    picture = None
    if options.plot is None and (options.plot_from, options.plot_to, options.width) != (None, None, WIDTH):
        raise UsageError("--from, --to and --width are of a picture; add --plot FILE")
    if options.plot is not None:
        from mossar_tools.figures import check_picture

        picture = check_picture(options.plot)
    from mossar_stream.recording import segment_recording
    from mossar_tools.streaming import saying_if_cold
    from mossar_tools.whole import read_whole

    whole = read_whole(options)
    console.status(f"segmenting {len(whole.times)} frames ...")
    with saying_if_cold():
        result = segment_recording(
            whole.positions,
            whole.fps,
            whole.skeleton,
            settings,
            times=whole.times,
            curves=picture is not None,
        )
    chosen = result.at(count=options.keep) if options.keep is not None else result.at(settings.level)
    console.clear()
    if options.json:
        report = {
            "v": 1,
            "recording": whole.name,
            "fps": whole.fps,
            "level": settings.level if options.keep is None else None,
            "key_frames": result.key_frames,
            "segments": chosen.segments,
        }
        console.line(msgspec.json.encode(report).decode())
    elif options.csv:
        console.line(_csv(chosen).rstrip("\n"))
    elif picture is None:
        from mossar_tools.tables import segmentation_table

        for line in segmentation_table(whole, result, chosen, console):
            console.line(line)
    if picture is not None:
        from mossar_tools.palette import DARK, LIGHT
        from mossar_tools.plot import draw

        console.status("drawing ...", now=True)
        palette, span = DARK if options.dark else LIGHT, (options.plot_from, options.plot_to)
        draw(picture, whole, result, chosen, palette, options.keep, span=span, width=options.width)
        console.say(f"drawn: {picture}")
    return DONE


def _csv(chosen: "Segmentation") -> str:
    strengths = {key.frame: key.strength for key in chosen.key_frames}
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for part in chosen.segments:
        strength = strengths.get(part.end_frame)
        times = (part.start_time, part.end_time, part.end_time - part.start_time)
        cells = [f"{time:.4f}" for time in times]
        table.writerow([*cells, part.state, "" if strength is None else f"{strength:.4f}"])
    return text.getvalue()
