"""The chart of the dashboard: the velocity curve with its key frames, as SVG."""

import xml.etree.ElementTree as ET

import numpy as np

from mossar_tools.dashboard.chart import chart


def test_key_frames_stand_on_the_curve(seen):
    (glimpse,) = seen.glimpses()
    drawn = ET.fromstring(chart([glimpse]))
    box = next(e for e in drawn.iter() if e.get("class") == "box")
    path = next(e for e in box.iter() if e.get("class") == "curve").get("d")
    x, y = np.array([point.split() for point in path.strip("M").split("L")], float).T
    top, room = float(box.get("y")), float(box.get("height"))
    placed = (e for e in drawn.iter() if "%" in e.get("x", "") and len(e))
    marks = [e for e in placed if "mark" in e[0].get("class", "")]
    assert len(marks) == len(glimpse.marks) > 5
    for mark in marks:
        place = 10 * float(mark.get("x")[:-1])
        # Both x are rounded, by a tenth in all: on a steep rise that is more than a pixel.
        curve = top + room * np.interp(np.linspace(place - 0.1, place + 0.1, 21), x, y) / 100
        assert curve.min() - 1.0 <= float(mark.get("y")) <= curve.max() + 1.0, ET.tostring(mark)


def test_the_chart_is_well_formed_and_quotes_names(seen):
    (glimpse,) = seen.glimpses()
    ET.fromstring(chart([glimpse]))
    other = type(glimpse)(
        **{name: getattr(glimpse, name) for name in glimpse.__struct_fields__} | {"performer": "<b>"}
    )
    assert "&lt;b&gt;" in chart([glimpse, other])
    assert "Waiting" in chart([])
