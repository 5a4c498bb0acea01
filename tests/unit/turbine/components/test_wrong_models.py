"""A wrong model is one sentence and exit code 2; an error of our own, or of numpy, a traceback."""

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx import Gravity, JointDamper, ModelError
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.components import loads, model

CASE = "turbine_fenicsx/demos/rigid.toml"


@pytest.fixture
def run(request, tmp_path):
    """Run the rigid turbine for one step on the command line."""
    case = str(request.config.rootpath / CASE)
    return lambda: main(["run", case, "--set", "time.end=0.02", "--quiet", "-o", str(tmp_path)])


WRONG = {
    "acceleration of gravity must be three numbers": lambda g: Gravity((0.0, np.nan, 0.0)),
    "no joint coordinate 'spin'; there are": lambda g: JointDamper("brake", "spin", 1.0),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_a_wrong_model_is_one_sentence(sentence, run, monkeypatch, capfd):
    monkeypatch.setattr(loads, "Gravity", WRONG[sentence])
    assert run() == 2
    lines = capfd.readouterr().err.splitlines()
    assert len(lines) == (MPI.COMM_WORLD.rank == 0)  # the first rank speaks for all
    assert all(line.startswith(f"error: {sentence}") for line in lines)


def test_a_stray_error_of_numpy_is_a_traceback(run, monkeypatch):
    def broken(*arguments, **options):
        return np.zeros(2) + np.zeros(3)

    monkeypatch.setattr(model, "MultibodySystem", broken)
    with pytest.raises(ValueError, match="could not be broadcast") as raised:
        run()
    assert not isinstance(raised.value, InputError)


def test_python_users_catch_wrong_models_as_such():
    with pytest.raises(ModelError, match="damping of 'brake' must not be negative"):
        JointDamper("brake", "rotor", -1.0)
