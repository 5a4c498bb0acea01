"""Words and curves of a verdict on a basis."""

import numpy as np

from turbine_fenicsx.reduction import verdict as module
from turbine_fenicsx.reduction.verdict import StateVerdict, Verdict


def state(path, time, error):
    s = np.linspace(0.0, 1.0, 5)
    return StateVerdict(path, time, 2.0, error * s, 0.1 * s, 0.01 * s, 0.17)


def test_the_picture_shows_the_worst_state_of_each_path(monkeypatch, tmp_path):
    states = (state("gust", 0.5, 0.1), state("gust", 1.0, 0.3), state("gust", 2.0, 0.2))
    verdict = Verdict(
        "blade", 6, 3, np.ones((2, 1)), {}, np.linspace(0.0, 1.0, 5),
        (*states, state("storm", 1.0, 0.4)), np.ones(3),
    )  # fmt: skip
    drawn = {}
    monkeypatch.setattr(module, "draw_basis", lambda *args: drawn.update(args[-1]))
    verdict.draw(tmp_path / "basis.png")
    assert list(drawn) == ["gust, at 1 s", "storm, at 1 s"]
    assert drawn["gust, at 1 s"][0][-1] == 15.0
    assert "residual: error of the strains by their energy" in str(verdict)
