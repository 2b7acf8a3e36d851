"""`mossar teach`: show moves, once or twice each, that `mossar run --moves` then recognises."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
import numpy as np

from mossar_adapters.files.options import ReadOptions
from mossar_stream import FACINGS, MoveRule
from mossar_tools import values
from mossar_tools.console import LOGGER, Console, prints_unicode
from mossar_tools.declared import Option, Section, operand
from mossar_tools.errors import DONE, UsageError
from mossar_tools.moves_file import changing, check_taught_name, moves_for, oddities_of, read_moves
from mossar_tools.options import Begin, Body, BodySegmenting, Messages, People, Picture, SpeedOfReading, Until

if TYPE_CHECKING:
    from mossar_stream import Example, Moves

DESCRIPTION = """Show moves that are recognised later. Live: rest, do the move, rest; it says when each example was
taken, and saves them together. From a recording: the movements in it, a part of it, or the moves of a table.
A pose that is held (--pose): rest, take the pose, hold it."""
COMMON = (
    "--help",
    "--name",
    "--pose",
    "--times",
    "--from",
    "--until",
    "--labels",
    "--discover",
    "--names",
    "--mirrored",
    "--list",
    "--remove",
    "--undo",
    "--keep",
    "--seconds",
)
EXAMPLES = """  mossar teach moves.json osc://0.0.0.0:39539 --name punch --times 2
  mossar teach moves.json take.bvh --name kick --from 3.2 --until 4.6
  mossar teach moves.json take.bvh --labels labels.csv        columns start, end (s), name
  mossar teach moves.json take.bvh --labels take.eaf --tier moves      as ELAN, Praat and others write
  mossar teach moves.json take.bvh --discover --plot kinds.png      which moves are in it?
  mossar teach moves.json take.bvh --discover --names punch,-,kick  call kinds 1 and 3 so
  mossar teach moves.json --name punch --strict 0.8 --again 0.5    fewer false punches, none twice
  mossar teach moves.json --name jab_left --mirrored               jab_right, too
  mossar teach moves.json --facing as_shown                        from the side it was shown only
  mossar teach moves.json osc://0.0.0.0:39539 --pose plank --hold 2     held for 2 s; the pose held at the end is saved
  mossar teach moves.json osc://0.0.0.0:39539 --name walk --seconds 4   no rest at its ends
  mossar teach moves.json --list
  mossar teach moves.json --undo
  mossar teach moves.json --remove punch
  mossar run osc://0.0.0.0:39539 --moves moves.json --emit move.confirmed
"""

LEAST_SECONDS, MOST_SECONDS = 0.5, 60.0  # s of an example of a fixed length


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    file: Annotated[str, operand("FILE.json", "file of moves; created if it does not exist")]
    sources: Annotated[tuple[str, ...], operand("SOURCE", "a stream or a recording", "*")] = ()
    name: Annotated[str | None, Section("examples of a move"), Option("name of the move", "NAME")] = None
    pose: Annotated[
        str | None,
        Option("name of a pose; the one held at the end is saved, once", "NAME"),
    ] = None
    hold: Annotated[
        float | None,
        Option("of --pose: how long until it counts as held (default: 1)", "SECONDS", values.seconds),
    ] = None
    times: Annotated[int, Option("number of examples (default: 2)", "N", values.count)] = 2
    seconds: Annotated[
        float | None,
        Option(
            "each example is the next S seconds, after a countdown: for moves without a rest at their ends",
            "S",
            values.positive,
        ),
    ] = None
    keeps: Annotated[
        bool,
        Option("keep an example that is unlike the others, instead of asking for it again", flag="keep"),
    ] = False
    begin: Begin = None
    until: Until = None
    labels: Annotated[
        str | None,
        Option(
            "table of many moves of a recording; .csv with columns start, end, name, or .eaf, .TextGrid, .txt, .vtt, .tsv, .json, .c3d",
            "FILE",
        ),
    ] = None
    tier: Annotated[str | None, Option("tier of --labels with the moves (default: moves)", "NAME")] = None
    discover: Annotated[
        bool, Section("an unlabelled recording"), Option("group its movements into kinds")
    ] = False
    names: Annotated[
        tuple[str, ...],
        Option(
            "names of the kinds in their order, - for none; the --times most typical examples of each are taken",
            "A,B,-,...",
            values.names,
        ),
    ] = ()
    picture: Picture = Picture()
    strict: Annotated[
        float | None,
        Section("rules of recognition, stored in the file"),
        Option(
            "of --name: from 0 (whatever is nearest) to 1 (only what is almost the same; default: 0.5)",
            "X",
            values.share,
        ),
    ] = None
    again: Annotated[
        float | None,
        Option("of --name: not confirmed again before so much time (default: 0)", "SECONDS", values.seconds),
    ] = None
    mirrored: Annotated[
        bool | None,
        Option(
            "of --name or --pose: its mirror image is recognised and followed, too; of jab_left as jab_right"
        ),
    ] = None
    facing: Annotated[
        Literal["any", "as_shown"] | None,
        Option("of all moves: recognised from any side, or only as they were shown (default: any)"),
    ] = None
    list: Annotated[
        bool, Section("contents of the file"), Option("list the moves, and draw each example")
    ] = False
    undo: Annotated[bool, Option("take back the last example, of --name or of all moves")] = False
    remove: Annotated[str | None, Option("remove a move or a pose", "NAME")] = None
    speed: Annotated[SpeedOfReading, Section("")] = None
    segmentation: BodySegmenting = BodySegmenting()
    body: Body = Body()
    people: People = People()
    messages: Messages = Messages()

    def reading(self) -> ReadOptions:
        """Return the options for reading a recording."""
        return self.body.reading(again=self.picture.force)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    _check_contents(options)
    if options.undo:
        return _undo(options, console)
    if options.list or options.remove is not None:
        return _list_or_remove(options, console)
    _check_pose(options)
    _check_live(options)
    if _has_rules(options) and options.name is None and options.pose is None:
        raise UsageError(
            "--strict, --again and --mirrored are of one move: --name says of which (--pose with --mirrored)"
        )
    if not options.sources and (_has_rules(options) or options.facing is not None):
        return _set_rules(options, console)
    _check_places(options)
    if options.discover:
        return _discover(options, console)
    if options.names or options.picture.plot is not None:
        raise UsageError("--names and --plot belong to --discover")
    if options.labels is not None:
        return _teach_labels(options, console)
    name = options.name or options.pose
    if name is None:
        raise UsageError(f"what is the move called? {_line(options)} (a held pose: --pose NAME)")
    check_taught_name(name)
    if options.begin is not None or options.until is not None:
        return _teach_parts(options, console, [(-np.inf, np.inf, name)])
    return _teach_live(options, console)


def _check_places(options: Options) -> None:
    """Refuse a command line without a source, with several, or with the source in the place of the file of moves."""
    if _is_source(options.file):
        files = [name for name in options.sources if name.lower().endswith(".json")] or ["moves.json"]
        exchanged = msgspec.structs.replace(options, file=files[0], sources=(options.file,))
        raise UsageError(f"the file of moves comes first: {_line(exchanged)}")
    if not options.sources:
        raise UsageError(f"what to learn from? {_line(msgspec.structs.replace(options, sources=('39539',)))}")
    if len(options.sources) > 1:
        last = options.sources[-1]
        named = options if options.name or _is_source(last) else msgspec.structs.replace(options, name=last)
        raise UsageError(f"one stream or recording at a time: {_line(named)}")


def _is_source(text: str) -> bool:
    """Return whether a text names a stream or a recording, and not a file of moves."""
    from mossar_tools.opening import command_for

    return not text.lower().endswith((".json", ".txt")) and command_for(text) is not None


def _line(options: Options) -> str:
    """Return a command line that teaches a move from the first source."""
    return f"mossar teach {options.file} {options.sources[0]} --name {options.name or options.pose or 'wave'}"


def _check_pose(options: Options) -> None:
    """Refuse options that do not apply to a pose.

    Raises:
        UsageError: If one is given.
    """
    if options.pose is None:
        if options.hold is not None:
            raise UsageError("--hold is of a pose: --pose says of which")
        return
    others = {
        "--name": options.name is not None,
        "--labels": options.labels is not None,
        "--discover": options.discover,
        "--strict": options.strict is not None,
        "--again": options.again is not None,
    }
    for other, is_given in others.items():
        if is_given:
            raise UsageError(f"{other} cannot be given with --pose")


def _check_contents(options: Options) -> None:
    """Refuse a stream beside options that only change or show the file.

    Raises:
        UsageError: If one is given.
    """
    alone = {"--undo": options.undo, "--list": options.list, "--remove": options.remove is not None}
    given = [name for name, is_given in alone.items() if is_given]
    if given and options.sources:
        raise UsageError(f"{given[0]} needs no stream: mossar teach {options.file} {given[0]}")
    if options.undo and len(given) > 1:
        raise UsageError(f"--undo and {given[1]} are two commands")
    if options.undo and options.pose is not None:
        raise UsageError("--undo takes back an example of a move; --remove takes back a pose")


def _check_live(options: Options) -> None:
    """Refuse options of live teaching without a stream.

    Raises:
        UsageError: If one is given.
    """
    parts = {
        "--from and --until": options.begin is not None or options.until is not None,
        "--labels": options.labels is not None,
        "--discover": options.discover,
        "--pose": options.pose is not None,
    }
    for name, is_given in {"--seconds": options.seconds is not None, "--keep": options.keeps}.items():
        if not is_given:
            continue
        if not options.sources:
            asked = f"{name} {options.seconds:g}" if name == "--seconds" else name
            raise UsageError(
                f"{name} needs a stream: mossar teach {options.file} osc://0.0.0.0:39539 --name walk {asked}"
            )
        for other, is_other in parts.items():
            if is_other:
                raise UsageError(f"{name} is for examples that are shown live; leave it out with {other}")
    if options.seconds is not None and not LEAST_SECONDS <= options.seconds <= MOST_SECONDS:
        raise UsageError(
            f"--seconds is the length of an example, from {LEAST_SECONDS:g} to {MOST_SECONDS:g} s, not {options.seconds:g}"
        )


def _undo(options: Options, console: Console) -> int:
    """Remove the last example, of the named move or of all."""
    from mossar_tools.moves_file import take_back

    example, left = take_back(options.file, options.name)
    moves = read_moves(options.file)
    console.say(f"{example.name}: the last example is taken back; {left} left")
    _draw(moves, [example], console)
    return DONE


def _draw(moves: "Moves", examples: Iterable["Example"], console: Console) -> None:
    from mossar_tools.figures_in_text import example_lines

    for example in examples:
        for line in example_lines(example, moves.skeleton, fine=prints_unicode(console.err)):
            console.say(f"  {line}")


def _hold(options: Options) -> float:
    return 1.0 if options.hold is None else options.hold


def _has_rules(options: Options) -> bool:
    return any(value is not None for value in (options.strict, options.again, options.mirrored))


def _set_rules(options: Options, console: Console) -> int:
    """Change the rules by which the moves of a file are recognised."""
    with changing(options.file) as moves:
        _apply_rules(options, moves)
    name = options.name or options.pose
    if name is not None:
        console.say(f"{name}: {_rule_text(moves, name) or 'recognised as usual'}")
    if options.facing is not None:
        console.say(f"{options.file}: facing {moves.facing}")
    return DONE


def _apply_rules(options: Options, moves: "Moves") -> None:
    if options.facing is not None:
        moves.facing = options.facing
    name = options.name or options.pose
    if name is not None and _has_rules(options):
        moves.set_rule(name, strict=options.strict, again=options.again, mirrored=options.mirrored)


def _rule_text(moves: "Moves", name: str) -> str:
    """Return the unusual rules of a move."""
    rule, usual = moves.rule(name), MoveRule()
    parts = [f"strict {rule.strict:g}"] if rule.strict != usual.strict else []
    parts += [f"again after {rule.again:g} s"] if rule.again else []
    parts += ["mirrored"] if rule.mirrored else []
    return ", ".join(parts)


def _warn(moves: "Moves", places: Iterable[int]) -> None:
    for line in oddities_of(moves, places):
        LOGGER.warning("%s", line)


def _list_or_remove(options: Options, console: Console) -> int:
    if options.remove is not None:
        with changing(options.file) as moves:
            moves.remove(options.remove)
        console.say(f"removed: {options.remove}")
    if options.list:
        moves = read_moves(options.file)
        for name in moves.names:
            lengths = [
                (len(e.positions) // (3 * len(moves.skeleton)) - 1) / e.fps
                for e in moves.examples
                if e.name == name
            ]
            spans = ", ".join(f"{length:.2f} s" for length in lengths)
            rule = _rule_text(moves, name)
            console.line(
                f"{name:<24} {len(lengths)} example{'s' if len(lengths) > 1 else ''}: {spans}{f'; {rule}' if rule else ''}"
            )
            _draw(moves, (example for example in moves.examples if example.name == name), console)
        for name, hold in {pose.name: pose.hold for pose in moves.poses}.items():
            rule = _rule_text(moves, name)
            console.line(f"{name:<24} pose, held after {hold:g} s{f'; {rule}' if rule else ''}")
        if moves.facing != FACINGS[0]:
            console.line(f"facing {moves.facing}")
        _warn(moves, range(len(moves)))
    return DONE


def _teach_labels(options: Options, console: Console) -> int:
    from mossar_adapters.annotations.reading import chosen_tier
    from mossar_adapters.annotations.tiers import MOVES

    path = options.labels or ""
    tier = chosen_tier(path, options.tier, (MOVES,))
    rows = [(mark.start, mark.end, mark.label.strip()) for mark in tier.marks]
    if not rows:
        raise UsageError(f"{path}: there are no moves in it")
    unnamed = next((start for start, _, name in rows if not name), None)
    if unnamed is not None:
        raise UsageError(f"{path}: the move at {unnamed:g} s has no name")
    return _teach_parts(options, console, rows, from_first=not tier.on_clock)


def _teach_parts(
    options: Options, console: Console, parts: list[tuple[float, float, str]], *, from_first: bool = False
) -> int:
    """Teach parts of a recording, all or none of them; times are on its clock, or count from the first frame.

    With `--from` and `--until` only the parts between them are taught.
    """
    from mossar_tools.loaded_recording import load_recording

    whole = load_recording(options.sources[0], options.reading(), people=options.people).held()
    if options.begin is not None or options.until is not None:
        whole = whole.part(options.begin, options.until)
    origin = whole.begin if from_first else 0.0
    if options.labels is not None:
        parts = _within(options, parts, origin)
    with changing(options.file, whole.skeleton) as moves:
        before = len(moves)
        for begin, until, name in parts:
            check_taught_name(name)
            positions, fps = whole.between(origin + begin, origin + until)
            if len(positions) < 2:
                where = (
                    f"from {origin + begin:g} s until {origin + until:g} s"
                    if np.isfinite(until - begin)
                    else "in this part"
                )
                raise UsageError(f"there are fewer than two frames {where} of {whole.name}")
            if options.pose is None:
                moves.add(name, positions, fps)
            else:
                moves.add_pose(name, positions, fps, _hold(options))
        _apply_rules(options, moves)
    _warn(moves, range(before, len(moves)))
    console.say(f"{options.file}: {len(parts)} taken; {_what_is_in(moves)}")
    return DONE


def _within(
    options: Options, parts: list[tuple[float, float, str]], origin: float
) -> list[tuple[float, float, str]]:
    """Return the moves of a table that lie between `--from` and `--until`.

    Raises:
        UsageError: If there is none.
    """
    low = -np.inf if options.begin is None else options.begin
    high = np.inf if options.until is None else options.until
    found = [part for part in parts if low <= origin + part[0] and origin + part[1] <= high]
    if not found:
        raise UsageError(f"none of the {len(parts)} moves lies between --from and --until")
    return found


def _discover(options: Options, console: Console) -> int:
    """Show the kinds of moves in a recording, and teach those with a name."""
    from mossar_tools.discovering import MOST_DRAWN, discover, draw_kinds, lines_of
    from mossar_tools.loaded_recording import load_recording
    from mossar_tools.outputs import Outputs
    from mossar_tools.palette import palette

    picture = Outputs.of(options).picture
    source = options.sources[0]
    whole = load_recording(
        source, options.reading(), people=options.people, begin=options.begin, until=options.until
    )
    if options.names:
        # Errors of the file are reported before the search for kinds, which takes long.
        moves_for(options.file, whole.skeleton)
    settings = options.segmentation.settings(source, range="file")
    kinds, left_out = discover(whole, settings)
    for line in lines_of(kinds):
        console.line(line)
    if left_out:
        console.say(f"{left_out} movements were too short, too small, incomplete or too many to compare")
    if picture is not None:
        draw_kinds(picture, whole, kinds, palette(dark=options.picture.dark))
        console.say(
            f"drawn: {picture}"
            + (f" ({MOST_DRAWN} of {len(kinds)} kinds)" if len(kinds) > MOST_DRAWN else "")
        )
    if not options.names:
        return DONE
    if len(options.names) > len(kinds):
        raise UsageError(f"--names has {len(options.names)} names; there are {len(kinds)} kinds of moves")
    with changing(options.file, whole.skeleton) as moves:
        before = len(moves)
        for name, kind in zip(options.names, kinds, strict=False):
            check_taught_name(name)
            for part in kind[: options.times] if name != "-" else ():
                moves.add(name, part.positions, part.fps)
        _apply_rules(options, moves)
    _warn(moves, range(before, len(moves)))
    console.say(f"{options.file}: {_what_is_in(moves)}")
    return DONE


def _what_is_in(moves: "Moves") -> str:
    examples, names = len(moves), len(moves.names)
    poses = len({pose.name for pose in moves.poses})
    held = f", {poses} pose{'s' * (poses != 1)}" if poses else ""
    return f"{examples} example{'s' * (examples != 1)} of {names} move{'s' * (names != 1)}{held}"


def _teach_live(options: Options, console: Console) -> int:
    """Teach moves from a live stream."""
    from mossar_tools.live_teaching import LiveTeaching

    teaching = LiveTeaching(options, console)
    status = teaching.run()
    if teaching.is_whole and (_has_rules(options) or options.facing is not None):
        _set_rules(options, console)
    return status
