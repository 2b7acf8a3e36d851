"""What programs and extras send: with sockets to other computers forbidden, everything local still works.

The table of SECURITY.md says what each extra sends. What Python sends is seen here; what compiled libraries do is not, so
their switches are looked at.
"""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ALONE = """
import ipaddress, socket, sys

def stay_here(event, arguments):
    if event == "socket.getaddrinfo":
        host = arguments[0]
    elif event in ("socket.connect", "socket.sendto"):
        host = arguments[1][0] if isinstance(arguments[1], tuple) else None
    else:
        return
    if host in (None, "", "localhost", b"localhost"):
        return
    host = host.decode() if isinstance(host, bytes) else host
    try:
        local = ipaddress.ip_address(host).is_loopback or ipaddress.ip_address(host).is_unspecified
    except ValueError:
        local = False
    if not local:
        sys.stderr.write(f"LEFT {event} {host}\\n")
        sys.stderr.flush()
        raise PermissionError(f"{event} {host}")

sys.addaudithook(stay_here)
"""
USES = {
    "none": ("run", "demo:?seconds=1", "--to", "osc://127.0.0.1:9", "--to", "zmq+bind://127.0.0.1:0"),
    "plot": ("segment", "demo:?seconds=3", "--plot", "a.png"),
    "annotate": ("segment", "demo:?seconds=3", "--export", "a.eaf"),
    "web": ("run", "demo:?seconds=1", "--to", "ws://127.0.0.1:0"),
    "metrics": ("run", "demo:?seconds=1", "--to", "-", "--metrics", "127.0.0.1:0"),
    "view": ("run", "demo:?seconds=1", "--to", "-", "--view", "--no-browser", "--port", "0"),
    "midi": ("run", "demo:?seconds=1", "--to", "midi:notes.bin"),
    "completion": ("completion", "bash"),
}
LIBRARIES = {
    "plot": "matplotlib",
    "annotate": "pympi",
    "web": "websockets",
    "metrics": "prometheus_client",
    "view": "viser",
    "midi": "mido",
    "completion": "shtab",
}


def alone(program, folder):
    """Run a program that may not talk to other computers."""
    places = os.pathsep.join(str(ROOT / part) for part in ("", "adapters", "tools"))
    return subprocess.run(
        [sys.executable, "-c", ALONE + program],
        env={**os.environ, "PYTHONPATH": places, "MPLCONFIGDIR": str(folder)},
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def test_what_is_forbidden_is_noticed(tmp_path):
    done = alone("socket.create_connection(('192.0.2.1', 9), 0.1)", tmp_path)
    assert done.returncode != 0
    assert "LEFT" in done.stderr


@pytest.mark.parametrize("extra", list(USES))
def test_nothing_leaves_this_computer(tmp_path, extra):
    if extra in LIBRARIES:
        pytest.importorskip(LIBRARIES[extra])
    done = alone(f"from mossar_tools.cli import main\nsys.exit(main({list(USES[extra])!r}))", tmp_path)
    assert "LEFT" not in done.stderr
    assert done.returncode == 0, done.stderr


def test_the_switches_of_compiled_libraries_are_off(tmp_path):
    pytest.importorskip("depthai")
    program = (
        "from mossar_adapters.oak.camera import load_sdk\nload_sdk()\n"
        "import os\nprint(os.environ['DEPTHAI_TELEMETRY'])"
    )
    assert alone(program, tmp_path).stdout.split()[-1:] == ["0"]


def test_the_table_of_what_is_sent_has_every_extra():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
        "optional-dependencies"
    ]
    rows = re.findall(r"^\| `([a-z]+)` \|", (ROOT / "SECURITY.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(rows) == sorted(extras)
