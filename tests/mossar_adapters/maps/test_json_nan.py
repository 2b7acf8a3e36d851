import pytest

from mossar_adapters.maps.json_nan import without_nan


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (b"[NaN, -Infinity, Infinity]", b"[null, null, null]"),
        (b'{"NaN": NaN, "a\\"NaN": "Infinity"}', b'{"NaN": null, "a\\"NaN": "Infinity"}'),
        (b"[1, null]", None),
        (b'[NaN, "cut off NaN', b'[null, "cut off NaN'),
        (b"[NaNs, xNaN]", b"[NaNs, xNaN]"),
    ],
)
def test_words_become_null_but_not_in_texts(text, expected):
    assert without_nan(text) == expected


def test_quotes_and_backslashes_without_end_take_no_time():
    assert without_nan(b'\\"' * 1_000_000 + b"NaN") is not None
