from checks.dashboard_delay import measure


def test_delays_are_measured_with_a_page_and_without(monkeypatch):
    monkeypatch.setattr("checks.dashboard_delay.SETTLED", 0.2)
    for page in (False, True):
        line = measure(1.0, page=page)
        assert line.startswith("median ")
        assert line.endswith(" 0 lost, 0 looking")
        assert int(line.split(" frames")[0].rpartition(" ")[2]) > 5
