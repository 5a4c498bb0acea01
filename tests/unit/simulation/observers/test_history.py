"""Claims about names in the head of a history."""

import pytest

from turbine_fenicsx import History, MultibodySystem, Revolute, RigidBody, Simulation
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import read_history
from turbine_fenicsx.simulation.observers.history import (
    Channel,
    angle_channel,
    energy_channel,
    read_columns,
    read_history_rows,
)

pytestmark = pytest.mark.parallel

BODY = RigidBody("body", 1.0, (1.0, 1.0, 1.0), angular_velocity=(0.0, 0.0, 1.0))


def turning(comm, name):
    return MultibodySystem(
        comm, [BODY, Revolute(name, None, BODY, point=(0, 0, 0), axis=(0, 0, 1))]
    )


@pytest.mark.parametrize("name", ['j,"x', "a,b", '"', "'", "two  words", " blank ", "ä,é", ""])
def test_names_with_commas_and_quotes_read_back(comm, shared_tmp_path, name):
    system, path = turning(comm, name), shared_tmp_path / "history.csv"
    history = History(comm, path, [energy_channel(), angle_channel(system)])
    Simulation(system, 0.01, 0.03, [history]).run()
    series = read_history(path)
    (column,) = [c for c in series.columns if c.startswith("angle_")]
    assert column == names.ANGLE(joint=name).strip()
    assert series[column] == pytest.approx([0.0, 0.01, 0.02, 0.03], abs=1e-5)
    columns = [*energy_channel().columns, *angle_channel(system).columns]
    assert read_columns(path) == columns
    assert len(read_history_rows(path, columns)) == 4
    saved = RestartData({"rows": 4, "columns": columns})
    assert history.find_shortfall(saved, 0.03) is None


@pytest.mark.parametrize(
    "name", ["new\nline", "null\0", "tab\t", "back\r", "\x1b[31m", "half \ud800"]
)
def test_names_with_control_characters_are_refused(comm, name):
    with pytest.raises(ModelError, match="must be printable text: change the name in it"):
        angle_channel(turning(comm, name))
    with pytest.raises(ModelError, match="must be printable text"):
        Channel((name,), lambda s: [0.0])
