"""Annotations: each format is opened by a reader that is not ours, and what is read back is what was written."""

import csv
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mossar_adapters.annotations.reading import read_annotations
from mossar_adapters.annotations.tiers import AnnotationError, Mark, Tier
from mossar_adapters.annotations.writing import check_annotations, write_annotations
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_sink
from mossar_stream import Event, MossarError, RepetitionEvent, Skeleton

TIERS = [
    Tier("segments", (Mark(0.0, 1.25, "resting"), Mark(1.25, 2.5, "moving hand"), Mark(3.0, 3.2, "a<b & c"))),
    Tier("key frames", (Mark(1.25, 1.25, "onset"), Mark(2.5, 2.5, "offset")), moments=True),
]


def written(tmp_path: Path, suffix: str) -> Path:
    path = tmp_path / f"take{suffix}"
    write_annotations(path, TIERS, 4.0)
    return path


def test_elan_documents_are_opened_by_pympi(tmp_path: Path) -> None:
    elan = pytest.importorskip("pympi").Elan
    document = elan.Eaf(str(written(tmp_path, ".eaf")))
    assert set(document.get_tier_names()) == {"segments", "key frames"}
    assert sorted(document.get_annotation_data_for_tier("segments"))[1] == (1250, 2500, "moving hand")


def test_textgrids_are_opened_by_another_library(tmp_path: Path) -> None:
    pytest.importorskip("pympi")
    textgrid = pytest.importorskip("textgrid")
    grid = textgrid.TextGrid.fromFile(str(written(tmp_path, ".TextGrid")))
    assert [tier.name for tier in grid] == ["segments", "key frames"]
    assert [(i.minTime, i.maxTime, i.mark) for i in grid[0] if i.mark][1] == (1.25, 2.5, "moving hand")
    assert [(p.time, p.mark) for p in grid[1]] == [(1.25, "onset"), (2.5, "offset")]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be"])
def test_textgrids_are_read_in_every_encoding_of_praat(tmp_path: Path, encoding: str) -> None:
    pytest.importorskip("pympi")
    path = written(tmp_path, ".TextGrid")
    text = path.read_text("utf-8").replace("moving", "zähes 動き")
    path.write_bytes((("\ufeff" if encoding == "utf-16-be" else "") + text).encode(encoding))
    tiers = {tier.name: tier for tier in read_annotations(path)}
    assert any("zähes 動き" in mark.label for mark in tiers["segments"].marks)


def test_cues_are_opened_by_a_webvtt_parser(tmp_path: Path) -> None:
    webvtt = pytest.importorskip("webvtt")
    cues = list(webvtt.read(str(written(tmp_path, ".vtt"))))
    assert [(cue.start, cue.end) for cue in cues][1] == ("00:00:01.250", "00:00:02.500")
    assert len(cues) == 3


def test_events_of_bids_are_a_table_with_onset_and_duration_first(tmp_path: Path) -> None:
    with written(tmp_path, ".tsv").open(newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    assert list(rows[0]) == ["onset", "duration", "trial_type", "value"]
    assert (rows[1]["onset"], rows[1]["duration"], rows[1]["trial_type"]) == (
        "1.250000",
        "0.000000",
        "key_frames",
    )
    assert [float(row["onset"]) for row in rows] == sorted(float(row["onset"]) for row in rows)


@pytest.mark.parametrize("suffix", [".eaf", ".TextGrid", ".txt", ".tsv"])
def test_what_is_written_is_read_back(tmp_path: Path, suffix: str) -> None:
    if suffix in {".eaf", ".TextGrid"}:
        pytest.importorskip("pympi")
    tiers = {tier.name: tier for tier in read_annotations(str(written(tmp_path, suffix)))}
    assert tiers["segments"].marks == TIERS[0].marks
    assert tiers["key frames"].moments
    assert tiers["key frames"].marks == TIERS[1].marks


WORDS = st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=1, max_size=12)


@st.composite
def tiers(draw: st.DrawFn) -> list[Tier]:
    """Return tiers as exports have them: whole milliseconds, stretches that do not overlap, moments apart."""
    names = draw(st.lists(WORDS.filter(lambda name: ":" not in name), min_size=1, max_size=3, unique=True))
    found = []
    for name in names:
        edges = sorted(draw(st.sets(st.integers(0, 100_000), min_size=2, max_size=8)))
        moments = draw(st.booleans())
        pairs = zip(edges, edges if moments else edges[1:], strict=False)
        marks = tuple(Mark(a / 1000, b / 1000, draw(WORDS)) for a, b in pairs)
        found.append(Tier(name, marks, moments=moments))
    return found


@given(tiers=tiers(), suffix=st.sampled_from([".eaf", ".TextGrid", ".txt", ".vtt", ".tsv"]))
@settings(deadline=None, max_examples=100)
def test_nothing_is_lost_on_the_way_there_and_back(tiers: list[Tier], suffix: str) -> None:
    if suffix in {".eaf", ".TextGrid"}:
        pytest.importorskip("pympi")
    if suffix == ".vtt":  # which has no moments
        tiers = [Tier(tier.name, tier.marks) for tier in tiers if not tier.moments]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"take{suffix}"
        write_annotations(path, tiers, 101.0)
        back = {tier.name: tier for tier in read_annotations(path)}
    assert set(back) == {tier.name for tier in tiers}
    for tier in tiers:
        found = back[tier.name].marks
        assert [mark.label for mark in found] == [mark.label for mark in tier.marks]
        assert [mark.start for mark in found] == pytest.approx([mark.start for mark in tier.marks], abs=1e-6)
        shortest = all(mark.end - mark.start < 0.0015 for mark in tier.marks)  # a moment in ELAN
        ends = [mark.start if shortest and suffix == ".eaf" else mark.end for mark in tier.marks]
        assert [mark.end for mark in found] == pytest.approx(ends, abs=1e-6)


HOSTILE = [
    Tier("=1+1 segments", (Mark(0.0, 1.0, "-kick"), Mark(1.0, 2.0, "'=2"))),
    Tier("<b>&", (Mark(3.0, 4.0, "@x"),)),
]


def test_events_of_bids_hold_no_formulas_and_read_back_as_they_were(tmp_path: Path) -> None:
    path = tmp_path / "take.tsv"
    write_annotations(path, HOSTILE, 4.0)
    with path.open(newline="") as file:
        rows = list(csv.reader(file, delimiter="\t"))
    assert not [text for row in rows for text in row if text[:1] in set("=+-@")]
    assert read_annotations(path) == HOSTILE


def test_names_of_cues_are_escaped(tmp_path: Path) -> None:
    path = tmp_path / "take.vtt"
    write_annotations(path, HOSTILE, 4.0)
    assert "&lt;b&gt;&amp;: @x" in path.read_text()
    assert read_annotations(path) == HOSTILE


@pytest.mark.parametrize("suffix", [".txt", ".vtt", ".tsv"])
def test_a_name_with_tabs_and_lines_adds_no_cells_and_no_lines(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"take{suffix}"
    write_annotations(path, [Tier("arm\t=1\n\nNOTE", (Mark(0.0, 1.0, "a\r\n2\tb\u2028c"),))], 4.0)
    (tier,) = read_annotations(path)
    assert tier.name.split(" ") == (["arm_=1__NOTE"] if suffix == ".tsv" else ["arm", "=1", "", "NOTE"])
    assert tier.marks == (Mark(0.0, 1.0, "a 2 b c"),)


def test_events_of_bids_are_opened_by_pandas_with_every_stretch_and_moment(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    table = pandas.read_csv(written(tmp_path, ".tsv"), sep="\t")
    expected = sorted(
        (mark.start, mark.end - mark.start, tier.name.replace(" ", "_"), mark.label)
        for tier in TIERS
        for mark in tier.marks
    )
    found = sorted(table[["onset", "duration", "trial_type", "value"]].itertuples(index=False, name=None))
    assert [row[2:] for row in found] == [row[2:] for row in expected]
    assert [row[:2] for row in found] == [pytest.approx(row[:2], abs=1e-6) for row in expected]


def test_labels_of_audacity_are_opened_by_pandas_with_every_stretch_and_moment(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    table = pandas.read_csv(written(tmp_path, ".txt"), sep="\t", header=None, names=["start", "end", "label"])
    expected = sorted(
        (mark.start, mark.end, f"{tier.name}: {mark.label}") for tier in TIERS for mark in tier.marks
    )
    assert sorted(table.itertuples(index=False, name=None)) == expected


def test_exports_of_label_studio_are_read(tmp_path: Path) -> None:
    path = tmp_path / "export.json"
    path.write_text(
        '[{"id": 1, "annotations": [{"result": [{"from_name": "label", "type": "timeserieslabels",'
        ' "value": {"start": 1.5, "end": 2, "timeserieslabels": ["Step"]}}]}]}]'
    )
    assert read_annotations(path) == [Tier("label", (Mark(1.5, 2.0, "Step"),))]


def test_frames_of_videos_in_exports_of_label_studio_are_times(tmp_path: Path) -> None:
    path = tmp_path / "export.json"
    path.write_text(
        '[{"data": {"fps": 25}, "annotations": [{"result": [{"from_name": "moves", "type": "timelinelabels",'
        ' "value": {"ranges": [{"start": 1, "end": 51}], "timelinelabels": ["Jump"]}}]}]}]'
    )
    assert read_annotations(path) == [Tier("moves", (Mark(0.0, 2.0, "Jump"),))]


def test_cues_of_other_programs_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.vtt"
    path.write_text(
        "WEBVTT - a title\n\nNOTE this is no cue\n\nSTYLE\n::cue { color: red }\n\n1\n00:01.000 --> 00:02.500 "
        "align:start\n<v Ann>up &amp;\ndown\n\n01:00:00.000 --> 01:00:01.000\nmoves: jump\n"
    )
    assert read_annotations(path) == [
        Tier("labels", (Mark(1.0, 2.5, "up & down"),)),
        Tier("moves", (Mark(3600.0, 3601.0, "jump"),)),
    ]


def test_events_of_other_bids_tables_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a_events.tsv"
    path.write_text("onset\tduration\ttrial_type\n1.5\tn/a\tgo_left\n2\t0.5\tgo_left\n3\t0\tn/a\n")
    assert read_annotations(path) == [
        Tier("go_left", (Mark(1.5, 1.5, "go_left"), Mark(2.0, 2.5, "go_left"))),
        Tier("events", (Mark(3.0, 3.0, ""),), moments=True),
    ]


def test_tables_of_labels_are_on_the_clock_of_the_recording(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("start,end,label,tier\n5,6,jump,\n1,2,rest,pauses\n")
    assert read_annotations(path) == [
        Tier("moves", (Mark(5.0, 6.0, "jump"),), on_clock=True),
        Tier("pauses", (Mark(1.0, 2.0, "rest"),), on_clock=True),
    ]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.txt", "1.0\tx\ty\n"),
        ("a.json", '{"no": "list"}'),
        ("a.json", '[{"annotations": [{"result": [{}]}]}]'),
        ("a.json", '[{"annotations": [{"result": [{"value": {"ranges": [{"start": 1, "end": 2}]}}]}]}]'),
        ("a.txt", "2.0\t1.0\tx\n"),
        ("a.txt", "nan\t1.0\tx\n"),
        ("a.vtt", "no header\n"),
        ("a.vtt", "WEBVTT\n\n00:01 --> later\nx\n"),
        ("a.vtt", ""),
        ("a.tsv", "start\tend\n1\t2\n"),
        ("a.tsv", "onset\tduration\n1\tlong\n"),
        ("a.tsv", "onset\tduration\n1\n"),
        ("a.csv", "begin,end,name\n1,2,x\n"),
        ("a.csv", "start,end,name\n1,,x\n"),
        ("a.csv", "start,end,name\n3,2,x\n"),
        ("a.csv", "start,end,name\ninf,inf,x\n"),
        ("a.json", '[{"annotations":' + "[" * 100_000),
        ("a.txt", "-inf\tinf\tx\n"),
        ("a.txt", "0\tnan\tx\n"),
    ],
)
def test_damaged_files_are_refused_in_one_line(tmp_path: Path, name: str, content: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(AnnotationError, match=name) as caught:
        read_annotations(tmp_path / name)
    assert "\n" not in str(caught.value)


def test_damaged_elan_documents_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("pympi")
    path = tmp_path / "a.eaf"
    path.write_text("<ANNOTATION_DOCUMENT><HEADER>")
    with pytest.raises(AnnotationError, match="ELAN"):
        read_annotations(path)


def test_a_path_may_be_text(tmp_path: Path) -> None:
    path = f"{tmp_path}/take.txt"
    check_annotations(path)
    write_annotations(path, TIERS, 4.0)
    assert [tier.name for tier in read_annotations(path)] == [tier.name for tier in TIERS]


def test_an_unknown_format_is_refused_before_the_work() -> None:
    with pytest.raises(AnnotationError, match=r"\.docx.*ELAN"):
        check_annotations(Path("take.docx"))


def sent(path: Path, *events: Event) -> list[Tier]:
    sink = open_sink(str(path))
    sink.announce(Meta("p1", Skeleton(("a", "b"), (-1, 0)), settings={"level": "motion"}))
    sink.begin_take("p1", 0, 100.0)
    sink.send(events)
    sink.close()
    sink.close()
    return read_annotations(path)


def repetition(number: int, status: str = "counted") -> RepetitionEvent:
    times = (100.0 + number, 101.0 + number) if status == "counted" else (None, None)
    return RepetitionEvent(
        performer="p1",
        id=f"p1/0/r{number}",
        rev=1,
        status=status,
        take=0,
        channel="body",
        count=number,
        total=number,
        period=1.0,
        tempo=60.0,
        start=times[0],
        end=times[1],
        amplitude=0.5,
        joint="hand",
        decided_time=103.0,
    )


def test_repetitions_that_were_withdrawn_are_not_annotated(tmp_path: Path) -> None:
    tiers = sent(tmp_path / "a.txt", repetition(1), repetition(2), repetition(2, "withdrawn"))
    assert {tier.name: tier.marks for tier in tiers}["repetitions"] == (Mark(1.0, 2.0, "1"),)


def test_a_file_that_is_there_is_refused_before_the_stream_begins(tmp_path: Path) -> None:
    path = tmp_path / "a.vtt"
    path.write_text("mine")
    with pytest.raises(MossarError, match="--force"):
        open_sink(str(path))
    with pytest.raises(MossarError, match="no folder"):
        open_sink(str(tmp_path / "b" / "a.vtt"))
