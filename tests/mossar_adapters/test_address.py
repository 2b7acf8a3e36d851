import pytest

from mossar_adapters.address import parse_url
from mossar_stream import SettingsError


@pytest.mark.parametrize(
    ("url", "scheme", "host", "port", "path"),
    [
        ("osc://127.0.0.1:39539", "osc", "127.0.0.1", 39539, ""),
        ("osc://:9000", "osc", "", 9000, ""),
        ("osc://[::1]:9000?profile=vmc", "osc", "::1", 9000, ""),
        ("zmq+bind://0.0.0.0:5556", "zmq+bind", "0.0.0.0", 5556, ""),
        ("ZMQ://Host:5556", "zmq", "host", 5556, ""),
        ("ipc:///tmp/pose", "ipc", "", None, "/tmp/pose"),
        ("demo:?seed=3", "demo", "", None, ""),
        ("lsl:", "lsl", "", None, ""),
        ("-", "-", "", None, ""),
        ("take.bvh", "file", "", None, "take.bvh"),
        ("a folder/take 1.bvh", "file", "", None, "a folder/take 1.bvh"),
        ("C:\\takes\\take.bvh", "file", "", None, "C:\\takes\\take.bvh"),
        ("file:take%201.bvh", "file", "", None, "take 1.bvh"),
        ("file:///tmp/take.bvh", "file", "", None, "/tmp/take.bvh"),
        ("file:///C:/take.bvh", "file", "", None, "C:/take.bvh"),
    ],
)
def test_urls_and_paths_are_taken_apart(url, scheme, host, port, path):
    address = parse_url(url)
    assert (address.scheme, address.host, address.port, address.path) == (scheme, host, port, path)


def test_options_keep_placeholders_and_escapes():
    options = parse_url("osc://:1?pattern=/pose/{performer}/{joint}&performer=Ada%20L").options
    assert options == {"pattern": "/pose/{performer}/{joint}", "performer": "Ada L"}


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("", "not an empty one"),
        ("osc://127.0.0.1:99999", "port must be a number"),
        ("osc://127.0.0.1:abc", "port must be a number"),
        ("osc://[::1:9000", "no URL"),
        ("osc://:1?fps", "?name=value"),
        ("osc://:1?fps=1&fps=2", "given twice"),
        ("osc://user@host:1", "no user name"),
        ("file://elsewhere/take.bvh", "on this computer"),
        ("file:", "path is missing"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(url, message):
    with pytest.raises(SettingsError) as caught:
        parse_url(url)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_options_are_refused_and_the_legal_ones_named():
    with pytest.raises(SettingsError, match="no option 'fsp'; there are: fps, unit"):
        parse_url("osc://:1?fsp=30").check({"fps": "", "unit": ""})


@pytest.mark.parametrize("text", ["x", "nan", "0", "1e9"])
def test_numbers_out_of_range_are_refused(text):
    with pytest.raises(SettingsError, match="fps must"):
        parse_url(f"osc://:1?fps={text}").number("fps", 0.001, 1e5)
