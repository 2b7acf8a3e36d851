"""Wrong lines as people type them: each is answered in one line that has the cure, and never with a traceback."""

import pytest

LINES = {
    "dance": "there are demo, run, segment",
    "segmnt walk.bvh": "did you mean segment?",
    "Segment walk.bvh": "did you mean segment?",
    "train": "did you mean mossar teach?",
    "plot": "did you mean mossar segment FILE --plot PICTURE.png?",
    "version": "did you mean mossar --version?",
    "--segment walk.bvh": "a command has no dashes: mossar segment",
    "help segmnt": "did you mean segment?",
    "wlk.bvh": "wlk.bvh: cannot be opened: No such file or directory - did you mean walk.bvh?",
    "run": "mossar run 39539",
    "run --port 39539": "to listen there: mossar run 39539",
    "run wlk.bvh": "did you mean walk.bvh?",
    "run 99999": "a port lies between 0 and 65535, as in 39539",
    "run localhost:99999": "as in localhost:39539",
    "run osc://": "a port is missing, as in osc://127.0.0.1:5556",
    "run udp://127.0.0.1:39539": "did you mean osc:?",
    "run tcp://127.0.0.1:5556": "did you mean zmq:?",
    "run webcm:": "did you mean webcam:?",
    "run demo: --to 99999": "a port lies between 0 and 65535",
    "run demo: --to game": "events go to .jsonl",
    "run demo: --levl motion": "did you mean --level?",
    "run demo: --level": "--level LEVEL (posture, motion, cluster",
    "run demo: --level strong": "it must be posture, motion, cluster or a number",
    "run demo: --set windw=2": "no setting called 'windw' - did you mean window?",
    "run demo: --set Window=2": "did you mean window?",
    "run demo: --set window": "is not of the form name=value",
    "run demo: --set window=0.25s": "it must lie between 0.01 and 10",
    "run demo: --set repetitions=yess": "it must be true or false",
    "run demo: --preset fast": "choose from",
    "run demo: --speed 2x": "is neither a positive number nor max",
    "run demo: --emit key_frames": "did you mean key_frame?",
    "run demo: --emit confirm": "did you mean confirmed?",
    "run demo: --follow squat": "--follow needs --moves FILE",
    "run demo: --moves missing.json": "missing.json cannot be read",
    "run demo: --explain": "--explain needs --moves",
    "run demo: --people two": "is not a number from 1 to 64, nearest or first",
    "run demo: --keep 3": "--keep is an option of mossar segment",
    "run demo: --unit meters": "choose from 'm', 'cm'",
    "run demo:?sed=3": "there are seed, performers",
    "run demo:?noise=5": "noise must lie in 0 to 1",
    "run demo: --metrics abc": "is not a port",
    "segment": "which recording?",
    "segment osc://127.0.0.1:39539": "which mossar run takes",
    "segment --csv walk.bvh": "mossar segment walk.bvh --csv",
    "segment walk.bvh --plot": "--plot FILE (draw a picture: .png, .svg or .pdf)",
    "segment walk.bvh --plot take": "pictures are .png, .svg, .pdf",
    "segment walk.bvh --keep many": "is not a whole number",
    "segment walk.bvh --from 0:90": "90, 1:30 and 0:01:30 are",
    "segment demo:?seconds=1 --from 1:30": "there are no frames from 90 s; it lasts from 0 s to",
    "segment walk.bvh --angles": "add --repetitions",
    "segment walk.bvh --repetition": "did you mean --repetitions?",
    "segment walk.bvh": "the file is empty",
    "view": "mossar view 39539",
    "teach moves.json walk.bvh": "mossar teach moves.json walk.bvh --name wave",
    "demo walk.bvh": "mossar demo takes options only",
    "demo --performers 100": "performers must lie in 1 to 64",
    "demo --performers 0": "'0' is not a whole number from 1",
    "evaluate demo: --seeds 0": "'0' is not a whole number from 1",
    "teach moves.json walk.bvh --name kick --times 0": "'0' is not a whole number from 1",
    "tune walk.bvh --per-minute 20 --tier mine": "--tier is of --labels FILE; add it",
    "tune demo:?seconds=2 --labels moves.json --tier mine": "a label file has no tiers; leave --tier out",
    "tune walk.bvh --limbs": "unrecognized arguments: --limbs -",
    "run demo: --config=": "cannot be read: Is a directory",
    "replay walk.bvh": "where to?",
    "settings window": "mossar settings takes options only",
    "settings --set windw=1": "did you mean window?",
    "adapters --check": "--check URL (",
    "completion fish": "choose from",
    "run osc://localhost": "a port is missing, as in osc://localhost:5556",
    "run 127.0.0.1": "a port is missing, as in 127.0.0.1:39539",
    "run osc:localhost:39539": "a port is missing, as in osc://localhost:39539",
    "run 39539,39540": "several are separated by spaces: 39539 39540",
    "run --source 39539": "SOURCE stands without an option: mossar run 39539",
    "run -p 39539": "SOURCE stands without an option: mossar run 39539",
    "run http://127.0.0.1:39539": "did you mean ws+bind:?",
    "run demo: --to http://127.0.0.1:9000": "did you mean ws:?",
    "run ws://127.0.0.1:8765": "ws+bind:// listens for senders",
    "run webcam": "there is no such file - did you mean webcam:?",
    "run demo": "did you mean demo:?",
    "run empty": "this is a folder without recordings of single frames (.json); name the recordings in it",
    "run moves.json": "this is a file of moves, for --moves",
    "run demo: --to zmq": "did you mean zmq://HOST:PORT?",
    "run demo: --to 127.0.0.1": "as in 127.0.0.1:39539",
    "run demo: --config levels.toml": "there is no option 'levle' - did you mean level?",
    "run demo: --repetitions 5": "--repetitions takes no value",
    "run demo: --window 0.3": "did you mean --set window=VALUE?",
    "run demo: -o out.jsonl": "did you mean --to?",
    "run demo: -q": "did you mean --quiet?",
    "segment demo": "did you mean demo:?",
    "segment 39539": "39539 is a stream, which mossar run takes",
    "segment demo:?seconds=1 --from 5 --until 2": "a part begins before it ends, not from 5 s until 2 s",
    "segment *.trc": "no file fits this pattern",
    "segment walk.bvh --threshold 0.1": "did you mean --set sig_threshold=0.05?",
    "segment walk.bvh --output out.csv": "did you mean --csv or --json or --plot?",
    "segment demo:?seconds=1 --csv out.xlsx": "did you mean --csv out.csv?",
    "segment demo:?seconds=1 --json out.csv": "--json writes JSON - did you mean --csv?",
    "teach walk.bvh": "the file of moves comes first: mossar teach moves.json walk.bvh --name wave",
    "teach walk.bvh my.json --name kick": "mossar teach my.json walk.bvh --name kick",
    "teach 39539 --name kick": "mossar teach moves.json 39539 --name kick",
    "teach moves.json --name kick": "what to learn from? mossar teach moves.json 39539 --name kick",
    "teach moves.json walk.bvh kick": "at a time: mossar teach moves.json walk.bvh --name kick",
    "replay demo: --to ws://127.0.0.1:0": "osc:// and zmq+bind:// do",
    "record webcam take.msk": "did you mean webcam:?",
    "view webcam:?model=tiny": "option model must be one of lite, full, heavy",
    "evaluate walk.bvh": "give a folder with recordings",
    "-v": "did you mean --version?",
}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "walk.bvh").touch()
    (tmp_path / "empty").mkdir()
    (tmp_path / "levels.toml").write_text("levle = 'motion'")
    (tmp_path / "moves.json").write_text('{"format": "mossar-moves", "examples": [], "rules": {}}')


@pytest.mark.parametrize("line", LINES)
def test_a_wrong_line_is_answered_in_one_line_with_the_cure(mossar, line):
    status, out, err = mossar(*line.split())
    said = [own for own in err.splitlines() if "this is mossar segment" not in own]
    assert (status, out) == (2, "")
    assert len(said) == 1, err
    assert said[0].startswith("mossar: error: ")
    assert LINES[line] in said[0]


@pytest.mark.parametrize("command", ["run", "segment"])
@pytest.mark.parametrize("folder", [".", ".."])
def test_a_folder_is_no_internal_error(mossar, command, folder):
    status, _, err = mossar(command, folder)
    assert status == 2
    assert "internal error" not in err


def test_there_are_many():
    assert len(LINES) >= 90


@pytest.mark.parametrize("command", ["run", "segment", "view", "teach", "demo"])
def test_help_fits_a_screen_and_the_rest_is_behind_help_all(mossar, monkeypatch, command):
    monkeypatch.setenv("COLUMNS", "80")
    status, short, _ = mossar(command, "--help")
    assert status == 0
    assert len(short.splitlines()) <= 50
    assert mossar("help", command)[1] == short
    status, whole, _ = mossar(command, "--help-all")
    assert status == 0
    assert "--log-json" in whole
    assert "--log-json" not in short
    assert "--help-all" in short


def test_commands_stand_in_three_groups(mossar):
    out = mossar("help")[1]
    assert [line for line in out.splitlines() if line in {"start:", "study:", "operate:"}] == [
        "start:",
        "study:",
        "operate:",
    ]
    assert out == mossar("--help")[1]


def test_a_recording_without_a_command_is_segmented(mossar, swing):
    status, out, err = mossar(swing, "--level", "posture")
    assert (status, out) == (0, mossar("segment", swing, "--level", "posture")[1])
    assert f"this is mossar segment {swing}" in err


@pytest.mark.parametrize(
    ("typed", "url", "where"),
    [
        ("0", "osc://0.0.0.0:0", "on all addresses of this computer"),
        ("localhost:0", "osc://127.0.0.1:0", "on 127.0.0.1"),
        ("osc:0", "osc://0.0.0.0:0", "on all addresses"),
    ],
)
def test_a_port_is_a_source(mossar, monkeypatch, typed, url, where):
    from mossar_adapters.pipeline import Pipeline

    opened = []
    before = Pipeline.run

    def run(pipeline):
        opened.extend(feed.source.name for feed in pipeline.feeds)
        pipeline.stop()
        return before(pipeline)

    monkeypatch.setattr(Pipeline, "run", run)
    status, _, err = mossar("run", typed)
    assert status == 0
    assert opened == [url]
    assert f"{typed} is {url}: OSC, {where}" in err
