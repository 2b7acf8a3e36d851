"""`mossar tune`: for someone with too many or too few key frames."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import numpy as np

from mossar_adapters.files.loaded import LoadedRecording
from mossar_adapters.files.replacing import Draft
from mossar_stream import Settings
from mossar_tools.console import Console, progress_of
from mossar_tools.declared import Option, Section, operand
from mossar_tools.errors import DONE, UsageError
from mossar_tools.loaded_recording import load_recording
from mossar_tools.options import Body, BodySegmenting, Messages, Picture
from mossar_tools.outputs import Outputs
from mossar_tools.palette import palette
from mossar_tools.settings_file import as_toml
from mossar_tools.values import positive

if TYPE_CHECKING:
    from mossar_stream import KeyFrame, Result
    from mossar_tools.evaluation.matching import Cut

DESCRIPTION = """Too many or too few key frames? Show how many key frames of a recording each strength keeps, and
choose a strength: by true cuts, or by the wanted number per minute. The settings can be saved for run --config."""
EXAMPLES = """  mossar tune walk.bvh                                  how many key frames stand at which strength
  mossar tune walk.bvh --plot walk.png                  with the picture of the hierarchy
  mossar tune walk.bvh --per-minute 20 --save settings.toml
  mossar tune walk.bvh --labels walk.json --save settings.toml
  mossar tune take.bvh --labels take.eaf --tier moves   what was annotated in ELAN
  mossar run osc://0.0.0.0:39539 --config settings.toml
"""
SHOWN = 12  # rows of the table


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    file: Annotated[str, operand("RECORDING", "a recording, or demo:")]
    per_minute: Annotated[
        float | None, Section("target and output"), Option("wanted key frames per minute", "N", positive)
    ] = None
    labels: Annotated[
        str | None,
        Option(
            "true cuts of the recording: .json, .eaf, .TextGrid, .txt (Audacity), .vtt, .tsv (BIDS), .csv, or a .c3d with events",
            "FILE",
        ),
    ] = None
    tier: Annotated[
        str | None, Option("tier of --labels with the cuts (default: segments LEVEL)", "NAME")
    ] = None
    save: Annotated[str | None, Option("write the settings to a file for --config", "FILE")] = None
    picture: Picture = Picture()
    segmentation: BodySegmenting = BodySegmenting()
    body: Body = Body()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    settings = options.segmentation.settings(options.file, range="file")
    if options.per_minute is not None and options.labels is not None:
        raise UsageError("--per-minute and --labels both choose; give one")
    if options.tier is not None and options.labels is None:
        raise UsageError("--tier is of --labels FILE; add it")
    if options.save is not None and options.per_minute is None and options.labels is None:
        raise UsageError("--save needs something to choose by: --per-minute N or --labels FILE")
    if options.save is not None and Path(options.save).exists() and not options.picture.force:
        raise UsageError(f"{options.save} is there already; --force replaces it")
    outputs = Outputs.of(options)
    recording = load_recording(options.file, options.body.reading(again=options.picture.force))
    truth = _truth(recording, settings, options)
    result = _segment(recording, settings, options)
    for line in _strengths(recording, result):
        console.line(line)
    strength = _chosen(recording, result, options.per_minute, truth, console)
    if options.save is not None and strength is not None:
        _save(Path(options.save), settings, strength)
        console.say(f"saved: {options.save}; use it with --config {options.save}")
    if outputs.picture is not None:
        from mossar_tools.plot import draw

        chosen = result.at(settings.level if strength is None else strength)
        draw(outputs.picture, recording, result, chosen, palette(dark=options.picture.dark))
        console.say(f"drawn: {outputs.picture}")
    return DONE


def _segment(recording: LoadedRecording, settings: Settings, options: Options) -> "Result":
    from mossar_stream import segment_recording

    return segment_recording(
        recording.positions,
        recording.fps,
        recording.skeleton,
        settings,
        times=recording.times,
        curves=options.picture.plot is not None,
        on_progress=progress_of(f"segmenting {recording.name}"),
    )


def _strengths(recording: LoadedRecording, result: "Result") -> Iterator[str]:
    """Yield a table of the number of key frames kept at each strength."""
    strengths = sorted((key.strength for key in result.key_frames), reverse=True)
    minutes = _minutes(recording)
    yield f"{recording.name}: {len(strengths)} key frames in {60 * minutes:.1f} s; level {result.settings.level}"
    yield f"{'strength':>9}{'key frames':>12}{'a minute':>10}"
    for count in sorted(
        set(np.linspace(len(strengths), 0, SHOWN).round().astype(int).tolist()), reverse=True
    ):
        strength = strengths[count - 1] if count else strengths[0] if strengths else 0.0
        sign = "" if count else ">"
        yield f"{sign + format(strength, '.3g'):>9}{count:>12}{count / minutes:>10.1f}"


def _minutes(recording: LoadedRecording) -> float:
    return max(float(recording.times[-1] - recording.times[0]) / 60.0, 1e-9)


def _truth(
    recording: LoadedRecording, settings: Settings, options: Options
) -> "tuple[Sequence[Cut], float] | None":
    """Return the true cuts and their tolerance, s; None if none were given."""
    if options.labels is None:
        return None
    from mossar_tools.evaluation.takes import cuts_of

    level = settings.resolved().level
    wanted = level if isinstance(level, str) else "motion"
    return cuts_of(Path(options.labels), recording.times, wanted, options.tier)


def _chosen(
    recording: LoadedRecording,
    result: "Result",
    per_minute: float | None,
    truth: "tuple[Sequence[Cut], float] | None",
    console: Console,
) -> float | None:
    """Return the strength that fits the options, and print its result; None without a target."""
    ranked = sorted(result.key_frames, key=lambda key: -key.strength)
    if per_minute is not None:
        count = min(round(per_minute * _minutes(recording)), len(ranked))
        strength = _between(ranked, count)
        console.line(f"level {strength:.3g}: {count} key frames, {count / _minutes(recording):.1f} a minute")
        return strength
    if truth is None:
        return None
    from mossar_tools.evaluation.metrics import score

    cuts, tolerance = truth
    start, duration = float(recording.times[0]), 60.0 * _minutes(recording)
    scores = [
        score(
            sorted(key.time for key in ranked[:count]),
            cuts,
            tolerance=tolerance,
            duration=duration,
            start=start,
        )
        for count in range(len(ranked) + 1)
    ]
    best = int(np.argmax([one.f1 for one in scores]))
    strength, reached = _between(ranked, best), scores[best]
    console.line(
        f"level {strength:.3g}: {best} key frames for {len(cuts)} cuts, F1 {reached.f1:.2f}, precision "
        f"{reached.precision:.2f}, recall {reached.recall:.2f} (chosen with the truth in sight)"
    )
    return strength


def _between(ranked: "list[KeyFrame]", count: int) -> float:
    """Return a strength at which `count` of the key frames are kept."""
    if not ranked:
        return 0.0
    above = ranked[count - 1].strength if count else 2.0 * ranked[0].strength + 1.0
    below = ranked[count].strength if count < len(ranked) else 0.0
    return (above + below) / 2.0


def _save(path: Path, settings: Settings, strength: float) -> None:
    """Write a file for --config."""
    try:
        with Draft(path) as draft:
            draft.path.write_text(as_toml(settings, strength, strength), encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror or error}") from None
