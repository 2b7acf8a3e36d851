"""Control messages of a sender that was there before the program was ready."""

from mossar_adapters.control.listener import ControlListener


def test_requests_wait_until_they_can_be_passed_on_the_latest_of_them():
    listener, heard = ControlListener(), []
    for k in range(100):
        listener.control("/mossar/set/level", [k])
    listener.pass_on_to(lambda address, arguments: heard.append((address, *arguments)))
    listener.control("/mossar/reset", [])
    assert heard[-2:] == [("/mossar/set/level", 99), ("/mossar/reset",)]
    assert len(heard) < 100
