"""`mossar segment`: a whole recording, offline."""

import argparse
from typing import TYPE_CHECKING, Any

from mossar_tools.console import Console
from mossar_tools.errors import DONE
from mossar_tools.options import Options, add_body, add_messages, add_output, add_plot, add_settings
from mossar_tools.outputs import Outputs
from mossar_tools.palette import palette
from mossar_tools.values import whole as whole_number

if TYPE_CHECKING:
    from mossar_stream.recording import Segmentation
    from mossar_tools.whole import Whole

DESCRIPTION = """Segment a whole recording, offline, with the range of the whole file: key frames, their hierarchy,
segments at a level. Without an option a table for people."""
EXAMPLES = """  mossar segment walk.bvh
  mossar segment walk.bvh --plot walk.png              also .svg and .pdf
  mossar segment 86_01.amc --level cluster --csv segments.csv
  mossar segment take.c3d --keep 12 --json | jq '.segments[].state'
  mossar segment demo:?seed=3 --plot demo.pdf --dark
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("file", metavar="FILE", help="a recording, or demo:")
    group = parser.add_argument_group("what to put out")
    add_output(group, "json", "all key frames with their strengths, and the segments")
    add_output(group, "csv", "a row for each segment: when, which frames, what it is like")
    add_plot(group)
    group.add_argument("--keep", metavar="K", type=whole_number, help="keep the K strongest key frames")
    add_settings(parser)
    add_body(parser)
    add_messages(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    settings = options.settings(range="file")
    outputs = Outputs.of(options)
    from mossar_stream.recording import segment_recording
    from mossar_tools.streaming import saying_if_cold
    from mossar_tools.whole import read_whole

    whole = read_whole(options)
    console.status(f"segmenting {len(whole.times)} frames ...")
    with saying_if_cold(settings):
        result = segment_recording(
            whole.positions,
            whole.fps,
            whole.skeleton,
            settings,
            times=whole.times,
            curves=outputs.picture is not None,
        )
    chosen = result.at(count=options.keep) if options.keep is not None else result.at(settings.level)
    console.clear()
    report = {
        "v": 1,
        "recording": whole.name,
        "fps": whole.fps,
        "level": settings.level if options.keep is None else None,
        "key_frames": result.key_frames,
        "segments": chosen.segments,
    }
    outputs.write_json(report, console)
    outputs.write_csv(_table(whole, chosen), console)
    if not outputs.silent:
        from mossar_tools.tables import segmentation_table

        for line in segmentation_table(whole, result, chosen, console):
            console.line(line)
    if outputs.picture is not None:
        from mossar_tools.plot import draw

        console.status("drawing ...", now=True)
        draw(outputs.picture, whole, result, chosen, palette(dark=options.dark), options.keep)
        console.say(f"drawn: {outputs.picture}")
    return DONE


def _table(whole: "Whole", chosen: "Segmentation") -> list[dict[str, Any]]:
    from mossar_adapters.segment_csv import COLUMNS, Ending, segment_row

    endings = {key.frame: Ending(key.kind, key.strength) for key in chosen.key_frames}
    rows = [
        segment_row(whole.name, whole.performer, 0, part, endings.get(part.end_frame, Ending()))
        for part in chosen.segments
    ]
    return [dict(zip(COLUMNS, row, strict=True)) for row in rows]
