"""The check of live teaching: sessions with known performances, and what counts as right."""

import sys

import numpy as np
import pytest

from checks import teaching
from mossar_adapters.demo.body import SKELETON


@pytest.fixture
def session():
    kick = teaching.performed(teaching.kick)
    return teaching.session("kick", SKELETON, [kick] * 2, 0.0, np.random.default_rng(1))


def test_a_session_says_when_its_performances_begin_and_end(session):
    still = round(session.true[0][0] * teaching.FPS) - 3
    before = np.ptp(session.positions[:still], axis=0).max()
    inside = slice(*(round(time * teaching.FPS) for time in session.true[0]))
    assert before < 4 * teaching.SWAY
    assert np.ptp(session.positions[inside], axis=0).max() > 0.5
    assert len(session.true) == 2


def test_all_that_is_taken_counts(session):
    assert teaching.play(session).is_right
    assert not teaching.Outcome(session, session.true[:1]).is_right
    assert not teaching.Outcome(session, [*session.true, (50.0, 51.0)]).is_right
    assert not teaching.Outcome(session, [(0.0, 0.5), (0.6, 0.7)]).is_right
    assert teaching.Outcome(session, session.true).errors(0) == [0.0, 0.0]


@pytest.mark.parametrize(("taken", "status"), [(2, 0), (1, 1)])
def test_too_many_wrong_sessions_fail(session, monkeypatch, capsys, taken, status):
    monkeypatch.setattr(teaching, "made_sessions", lambda: iter([session, session]))
    outcomes = iter(teaching.Outcome(session, session.true[:count]) for count in (2, taken))
    monkeypatch.setattr(teaching, "play", lambda _: next(outcomes))
    monkeypatch.setattr(sys, "argv", ["teaching"])
    assert teaching.main() == status
    assert f"made: {taken} of 2 sessions right" in capsys.readouterr().out
