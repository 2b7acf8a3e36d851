"""Ctrl-C while the program is imported ends it without a traceback."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": os.pathsep.join(map(str, (ROOT, ROOT / "adapters", ROOT / "tools"))),
}
PROGRAM = """
import os, sys
from mossar_tools import entry

class Interrupts:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), {number})

sys.meta_path.insert(0, Interrupts())
sys.argv = ["mossar", "demo", "--seconds", "1", "--speed", "max"]
sys.exit(entry.main())
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows sends signals otherwise")
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("module", ["mossar_tools.cli", "argparse", "mossar_tools.streaming", "numpy"])
def test_a_signal_during_the_imports_is_no_traceback(module, number, status):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(module=module, number=int(number))],
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
        check=False,
        timeout=120,
    )
    assert done.returncode == status
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(os.name == "nt", reason="Windows sends signals otherwise")
def test_a_signal_in_the_script_of_pip_is_no_traceback():
    program = (
        "import os, signal; from mossar_tools.entry import main; os.kill(os.getpid(), signal.SIGINT); main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
        check=False,
        timeout=120,
    )
    assert (done.returncode, done.stderr) == (130, "")
