"""Claims about the text file in OpenFAST's format."""

from pathlib import Path

import numpy as np
import pytest
from seen import Seen

from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.openfast import OpenFastOutput, read_out_rows
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

CHANNELS = [
    Channel(("RotSpeed_[rpm]", "RootMyb1_[kN-m]"), lambda s: [1.0 / 3.0, -1.5e4 * s.index]),
    Channel(("Wave1Elev_[m]",), lambda s: [-(s.state.time**2)]),
]
NAMES = ["Time", "RotSpeed", "RootMyb1", "Wave1Elev"]
UNITS = ["s", "rpm", "kN-m", "m"]


def toolbox(path):
    """Read a file the way openfast_toolbox and pyDatView do: by the line that begins with Time.

    Returns:
        Data, columns as ``Name_[unit]``, and the lines above.
    """
    above = []
    with Path(path).open(encoding="ascii", errors="ignore") as file:
        for _ in range(35):
            line = file.readline()
            first = (line + " dummy").lower().split()[0]
            if first in ("time", "alpha"):
                break
            above.append(line)
        names, units = line.split(), [unit[1:-1] for unit in file.readline().split()]
        data = np.loadtxt(file, comments="This")
    return data, [f"{n}_[{u}]" for n, u in zip(names, units, strict=True)], above


@pytest.fixture
def system(comm, machine):
    m = machine(spin=3.0)
    return MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor])


def write(system, path, end=0.06, step=0.02, **options):
    output = OpenFastOutput(system.comm, path, CHANNELS, **options)
    Simulation(system, step, end, [output]).run()


def test_the_readers_of_the_wind_community_read_it(system, shared_tmp_path):
    path = shared_tmp_path / "history.out"
    title = "Rotor\n größer, time 12"
    write(system, path, title=title, note="Azimuth is 0")
    expected = [[t, 1 / 3, -1.5e4 * k, -(t**2)] for k, t in ((1, 0.02), (2, 0.04), (3, 0.06))]
    data, columns, above = toolbox(path)
    assert columns == [f"{n}_[{u}]" for n, u in zip(NAMES, UNITS, strict=True)]
    assert len(above) == 6
    assert np.allclose(data, expected, rtol=1e-6, atol=0)  # seven digits are written

    from openfast_io.FAST_output_reader import FASTOutputFile

    read = FASTOutputFile(str(path))
    assert read.info["attribute_names"] == NAMES and read.info["attribute_units"] == UNITS
    assert read.info["description"] == "Description: Rotor gr??er, time 12"
    assert np.array_equal(read.data, data)


def test_layout_is_that_of_openfast(system, shared_tmp_path):
    """Eight lines of head, cells of one width, tabs between."""
    path = shared_tmp_path / "history.out"
    write(system, path)
    lines = path.read_text(encoding="ascii").split("\n")
    assert [bool(line) for line in lines[:8]] == [
        False,
        True,
        False,
        False,
        True,
        False,
        True,
        True,
    ]
    assert {len(cell) for line in lines[6:-1] for cell in line.split("\t")} == {14}
    assert lines[-1] == "" and len(lines) == 8 + 3 + 1


def test_there_is_no_row_of_the_initial_state(system, shared_tmp_path):
    path = shared_tmp_path / "history.out"
    write(system, path, end=0.0)
    assert read_out_rows(path, len(NAMES)) == []


def test_rows_can_be_read_while_the_run_goes_on(comm, system, shared_tmp_path):
    path = shared_tmp_path / "history.out"

    def count(snapshot):
        comm.barrier()
        rows = len(path.read_text().splitlines()) - 8
        comm.barrier()
        return rows

    seen = Seen(count)
    output = OpenFastOutput(comm, path, CHANNELS)
    Simulation(system, 0.02, 0.06, [output, seen]).run()
    assert seen.values == [0, 1, 2, 3]


def test_tiny_steps_keep_their_times_apart(system, shared_tmp_path):
    path = shared_tmp_path / "history.out"
    write(system, path, step=1e-9, end=3e-9)
    assert toolbox(path)[0][:, 0].tolist() == [1e-9, 2e-9, 3e-9]


def test_rows_up_to_a_time_can_be_kept_and_appended_to(comm, system, shared_tmp_path):
    path = shared_tmp_path / "history.out"
    write(system, path, step=0.01, end=0.05)
    whole = path.read_text()
    comm.barrier()
    if comm.rank == 0:
        path.write_text(whole + "          0.06\t  1.0")  # cut off by a crash
    comm.barrier()
    assert len(read_out_rows(path, len(NAMES))) == 5
    comm.barrier()
    output = OpenFastOutput(comm, path, CHANNELS)
    output.start(Simulation(system, 0.01, 0.01 + 0.02).run(), resumed=True)
    output.finish()
    assert path.read_text().split("\n") == [*whole.split("\n")[:11], ""]


def test_a_missing_file_has_no_rows_to_keep(comm, system, shared_tmp_path):
    output = OpenFastOutput(comm, shared_tmp_path / "history.out", CHANNELS)
    output.start(Simulation(system, 0.01, 0.01).run(), resumed=True)
    output.finish()
    assert read_out_rows(shared_tmp_path / "history.out", len(NAMES)) == []


def test_a_file_that_cannot_be_written_is_an_error_on_all_ranks(comm, system, shared_tmp_path):
    output = OpenFastOutput(comm, shared_tmp_path / "none" / "history.out", CHANNELS)
    with pytest.raises(OSError, match=r"history\.out"):
        Simulation(system, 0.02, 0.02, [output]).run()
