import os
import subprocess
import sys

import pytest

from mossar_adapters.address import parse_url
from mossar_stream import FrameError, MossarError

ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


def test_the_library_says_nothing_unless_the_program_wants_it():
    code = "import logging, mossar_adapters; logging.getLogger('mossar.pipeline').warning('hello')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, env=ENVIRONMENT)
    assert (done.stdout, done.stderr) == (b"", b"")


def test_an_error_is_one_printable_line_whatever_it_quotes():
    with pytest.raises(MossarError) as raised:
        parse_url("osc://a\x1b[2J\nb:x")
    assert str(raised.value).isprintable()
    assert str(FrameError("a\r\n\x07b\udc80")) == "a   b "
