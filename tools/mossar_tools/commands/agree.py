"""`mossar agree`: agreement on labels between people, or between a person and the program."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec

from mossar_tools.console import Console
from mossar_tools.declared import Option, Section, operand
from mossar_tools.errors import DONE, UsageError
from mossar_tools.options import Messages, Picture, output
from mossar_tools.outputs import Outputs
from mossar_tools.palette import palette
from mossar_tools.values import names, tolerances

if TYPE_CHECKING:
    from mossar_tools.agreement.measures import Agreement

DESCRIPTION = """Compare label files of the same recordings: of two or more people, or of a person and the program. Files are
.eaf (ELAN), .TextGrid (Praat), .txt (Audacity), .vtt (WebVTT), .tsv (BIDS), .csv, .json (Label Studio) and .c3d (events).
Of folders, files of the same name are compared, each recording by itself and all together. It prints how many boundaries
agree within tolerances (F1), Cohen's kappa of the names over time, the offsets of the boundaries, and the confusion of
names."""
EXAMPLES = """  mossar agree ann.eaf bo.eaf --tier moves
  mossar agree ann.eaf found.csv --tier moves,moves     a person and what mossar segment --csv found
  mossar agree ann.eaf bo.eaf --plot agreement.png
  mossar agree ANN BO --csv agreement.csv              folders: by file, and pooled
  mossar agree ann.eaf bo.eaf --tolerance 0.05,0.2 --json
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    sources: Annotated[tuple[str, ...], operand("LABELS", "a file, or a folder, of each labeller", "+")]
    tier: Annotated[
        str | None,
        Section("comparison and output"),
        Option("a tier for all files, or one for each (default: the common one)", "NAME[,NAME...]"),
    ] = None
    tolerance: Annotated[
        tuple[float, ...],
        Option("tolerances of boundaries, s (default: 0.05,0.1,0.25,0.5)", "S[,S...]", tolerances),
    ] = ()
    json: Annotated[str | None, output("everything, with offsets and confusion")] = None
    csv: Annotated[
        str | None, output("a row for each pair of labellers and recording, and one for all recordings")
    ] = None
    picture: Picture = Picture()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_tools.agreement.files import recordings_of, tiers_of
    from mossar_tools.agreement.measures import TOLERANCES, agreement, pooled

    if len(options.sources) < 2:
        raise UsageError("agreement takes two or more: the labels of one, and those of another")
    outputs = Outputs.of(options)
    recordings = recordings_of(options.sources)
    wanted = names(options.tier) if options.tier else ()
    tiers = {name: tiers_of(paths, wanted) for name, paths in recordings.items()}
    limits = options.tolerance or TOLERANCES
    labellers = _labellers(options.sources)
    report, rows = [], []
    wholes: list[Agreement] = []
    for (i, one), (j, other) in itertools.combinations(enumerate(labellers), 2):
        parts = {name: agreement(own[i], own[j], limits) for name, own in tiers.items()}
        wholes.append(pooled(list(parts.values())))
        every = [*parts.items(), ("all", wholes[-1])]
        rows += [{"a": one, "b": other, "recording": name, **part.summary} for name, part in every]
        report.append({"a": one, "b": other, **_as_json(parts, wholes[-1])})
    found = {"v": 1, "tolerances": list(limits), "pairs": report}
    outputs.write(console, found, [_rounded(row) for row in rows], _table(rows, wholes, labellers))
    if outputs.picture is not None:
        from mossar_tools.agreement.drawing import draw_agreement

        draw_agreement(outputs.picture, labellers, tiers, wholes[0], palette(dark=options.picture.dark))
        console.say(f"drawn: {outputs.picture}")
    return DONE


def _labellers(sources: Sequence[str]) -> list[str]:
    """Return the name of each labeller: the file's name, with as much of its path as makes the names unique."""
    paths = [Path(source) for source in sources]
    for depth in range(1, max(len(path.parts) for path in paths) + 1):
        found = ["/".join(path.parts[-depth:]) for path in paths]
        if len(set(found)) == len(found):
            return found
    return [f"{number}. {path.name}" for number, path in enumerate(paths, 1)]


def _as_json(parts: "Mapping[str, Agreement]", whole: "Agreement") -> dict[str, Any]:
    return {
        "recordings": [{"recording": name, **_details(part)} for name, part in parts.items()],
        "all": _details(whole),
    }


def _details(part: "Agreement") -> dict[str, Any]:
    confusion = [{"a": a, "b": b, "amount": value} for (a, b), value in sorted(part.confusion.items())]
    unit = "moments" if part.moments else "s"
    return {**part.summary, "offsets": part.offsets, "confusion": confusion, "confusion_unit": unit}


def _rounded(row: Mapping[str, Any]) -> dict[str, Any]:
    return {
        key: "" if value is None else f"{value:.4f}" if isinstance(value, float) else value
        for key, value in row.items()
    }


def _table(
    rows: Sequence[Mapping[str, Any]], wholes: "Sequence[Agreement]", labellers: Sequence[str]
) -> Iterator[str]:
    """Yield a table for people, and the most frequent confusions."""
    scores = [key for key in rows[0] if key.startswith("f1_")]
    heading = "".join(f"{'F1 ' + key[3:] + ' s':>12}" for key in scores)
    yield f"{'':<40}{'boundaries':>14}{heading}{'kappa':>8}{'offset':>20}"
    for row in rows:
        name = f"{row['a']} : {row['b']}, {row['recording']}"
        counts = f"{row['boundaries_a']} : {row['boundaries_b']}"
        values = "".join(f"{row[key]:>12.2f}" for key in scores)
        kappa = "" if row["kappa"] is None else f"{row['kappa']:.2f}"
        spread = "" if row["offset_sd"] is None else f" ± {1000 * row['offset_sd']:.0f}"
        offset = "" if row["offset_mean"] is None else f"{1000 * row['offset_mean']:+.0f}{spread} ms"
        yield f"{name:<40}{counts:>14}{values}{kappa:>8}{offset:>20}"
    for (one, other), whole in zip(itertools.combinations(labellers, 2), wholes, strict=True):
        wrong = sorted(((v, a, b) for (a, b), v in whole.confusion.items() if a != b and v > 0), reverse=True)
        unit = "times" if whole.moments else "s"
        for value, a, b in wrong[:3]:
            yield f"{one} has {a or 'nothing'} where {other} has {b or 'nothing'}: {value:.4g} {unit}"
