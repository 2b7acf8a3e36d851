"""Shells complete commands and options; bash is asked what it would offer."""

import shutil
import subprocess

import pytest

ASK = """
{script}
COMP_WORDS=({words}); COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 ))
_shtab_mossar {last} >/dev/null 2>&1
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.fixture
def offered(mossar):
    """Return what bash offers after some words, the last of which is begun."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("there is no bash here")
    script = mossar("completion", "bash")[1]

    def ask(*words):
        text = ASK.format(script=script, words=" ".join(f"'{word}'" for word in words), last=words[-1])
        done = subprocess.run([bash, "--norc", "-c", text], capture_output=True, text=True, check=True)
        return done.stdout.split()

    return ask


def test_commands_are_completed(offered):
    assert offered("mossar", "se") == ["segment", "settings"]


def test_options_are_completed(offered):
    assert "--remerge" not in offered("mossar", "run", "--")
    assert {"--to", "--emit", "--level"} <= set(offered("mossar", "run", "--"))
    assert offered("mossar", "segment", "--pres") == ["--preset"]


@pytest.mark.parametrize("shell", ["zsh", "tcsh"])
def test_other_shells_get_a_script_too(mossar, shell):
    status, out, _ = mossar("completion", shell)
    assert status == 0
    assert "mossar" in out
    assert "segment" in out


def test_a_shell_that_is_not_known_is_wrong_usage(mossar):
    status, _, err = mossar("completion", "fish")
    assert status == 2
    assert "invalid choice: 'fish'" in err
