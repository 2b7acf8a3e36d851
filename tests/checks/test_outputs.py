import pytest

from checks.outputs import WAYS, cases, unknown_options, wrong


def test_every_option_that_looks_like_a_file_is_read_or_written():
    assert unknown_options() == []


@pytest.mark.parametrize(
    "case", tuple(cases()), ids=lambda case: f"{case.command}-{case.written}-{case.read}"
)
def test_no_output_replaces_an_input(case):
    assert [wrong(case, way) for way in WAYS] == ["", "", ""]
