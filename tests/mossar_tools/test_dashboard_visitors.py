"""Other devices see the dashboard by a URL that serves once; this computer needs none."""

from types import SimpleNamespace

import pytest

from mossar_stream import Settings
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.page import Page
from mossar_tools.dashboard.visitors import Visitors

PHONE, OWN = "192.0.2.9", "192.0.2.1:8080"


def visit(visitors, path="/", peer=PHONE, **headers):
    """Return the answer that a visitor gets instead of the page, None if it gets the page."""
    answered = []

    def respond(status, text):
        answered.append(SimpleNamespace(status=int(status), text=text, headers={}))
        return answered[-1]

    connection = SimpleNamespace(remote_address=(peer, 50000), respond=respond)
    return visitors.refusal(connection, SimpleNamespace(path=path, headers={"Host": OWN, **headers}))


@pytest.fixture
def invited():
    """Visitors of a page at an address, the first URL, and the URLs that were printed later."""
    later = []
    visitors = Visitors("192.0.2.1", later.append)
    return visitors, visitors.invitation(8080), later


def test_a_device_without_the_url_is_turned_away(invited):
    visitors, _, _ = invited
    for path in ("/", "/?key=", "/?key=wrong", "/mossar/seek?1"):
        assert visit(visitors, path).status == 403
    assert visit(visitors, Cookie="mossar=wrong").status == 403
    assert visit(visitors, Cookie="\x00=;;").status == 403


def test_the_url_serves_once_and_the_cookie_from_then_on(invited):
    visitors, url, later = invited
    assert url.startswith("http://192.0.2.1:8080/?key=")
    path = url.partition("8080")[2]
    answer = visit(visitors, path)
    assert (answer.status, answer.headers["Location"]) == (303, "/")
    cookie = answer.headers["Set-Cookie"]
    assert {"HttpOnly", "SameSite=Lax"} <= set(cookie.split("; "))
    ours = {"Cookie": f"other=1; {cookie.partition(';')[0]}"}
    assert visit(visitors, "/", **ours) is None
    assert visit(visitors, "/", Origin=f"http://{OWN}", **ours) is None
    assert visit(visitors, "/", Origin="http://evil.example", **ours).status == 403
    assert visit(visitors, path).status == 403, "it served twice"
    assert len(later) == 1
    assert visit(visitors, later[0].partition("8080")[2]).status == 303


def test_this_computer_needs_no_url_and_pages_of_others_stay_out(invited):
    visitors, _, _ = invited
    assert visit(visitors, peer="127.0.0.1") is None
    assert visit(visitors, peer="::ffff:127.0.0.1", Origin="http://localhost:8080") is None
    assert visit(visitors, peer="127.0.0.1", Origin="http://evil.example").status == 403


@pytest.mark.parametrize(("host", "told"), [("127.0.0.1", False), ("localhost", False), ("0.0.0.0", True)])
def test_a_url_is_printed_only_where_other_devices_reach_the_page(caplog, host, told):
    with caplog.at_level("INFO", "mossar"):
        page = Page(LiveShow(Settings()), 0, host=host)
        page.start(open_browser=False)
        page.close()
    said = [message for message in caplog.messages if "lets in once" in message]
    assert len(said) == told
    assert all(f":{page.port}/?key=" in message for message in said)
