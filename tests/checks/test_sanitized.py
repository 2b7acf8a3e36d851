"""What the check of the sanitizers runs; that they find something is seen to by the check itself."""

import pytest

from checks.sanitized import programs

PYTEST = ["-m", "pytest", "-p", "no:cacheprovider"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], [[*PYTEST, "tests/mossar_stream"]]),
        (["-x", "tests/a"], [[*PYTEST, "-x", "tests/a"]]),
        (["--program", "-m", "checks.fuzz"], [["-m", "checks.fuzz"]]),
        (["tests/a", "--program", "-c", "0"], [[*PYTEST, "tests/a"], ["-c", "0"]]),
    ],
)
def test_tests_a_program_or_both_are_run(words, expected):
    assert programs(words) == expected
