"""Claims about towers that move by few vectors beside rigid blades."""

import numpy as np
import pytest
from reduced_turbines import COMM, read, run, write_case

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.turbine.run.full_motion import FullMotion
from turbine_fenicsx.turbine.run.gauge_history import find_gauge_history
from turbine_fenicsx.turbine.run.ply_history import PlyRecovery
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun

RIGID = ("turbine.model=rigid", "output.twists=[]", "tower.elements=[6,1,6]")
TOP = "tower_top_displacement_x_[m]"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The case, whose blades are made rigid."""
    return write_case(on_rank0(COMM, lambda: tmp_path_factory.mktemp("towers")))


@pytest.fixture(scope="module")
def outs(path):
    """Folders of runs by the model of the tower."""
    return {m: run(path, m, *RIGID, f"tower.model={m}") for m in ("full", "reduced", "beam")}


@pytest.mark.parallel
@pytest.mark.parametrize(("model", "bound"), [("reduced", 2e-3), ("beam", 0.05)])
def test_they_carry_the_rotor_as_the_whole_mesh_does(outs, model, bound):
    found, full = read(outs[model]), read(outs["full"])
    for name in (TOP, "tower_base_moment_y_[Nm]"):
        assert np.max(np.abs(found[name] - full[name])) < bound * np.max(np.abs(full[name])), name
    energy = np.max(np.abs(found["energy_error_[J]"]))
    assert energy < 1e-8 * np.max(np.abs(found["total_energy_[J]"]))


@pytest.mark.parametrize("model", ["reduced", "beam"])
def test_their_motion_is_kept_and_gives_fields_but_no_plies(outs, model):
    recorded = RecordedRun.open(outs[model], COMM)
    motion = FullMotion(recorded)
    (u,) = motion.find_state(len(recorded.motion.times) - 1).u
    if model == "reduced":  # beams have no nodes of their own
        y = motion.turbine.system.flexible_models[0].positions[:, 1]
        top = u.array.reshape(-1, 3)[y > y.max() - 1e-6, 2]  # the section tilts
        assert top.mean() == pytest.approx(read(outs[model])[TOP][-1], rel=1e-2)
    with pytest.raises(InputError, match="no plies"):
        PlyRecovery(recorded)
    with pytest.raises(InputError, match="no strains"):
        find_gauge_history(recorded)
    pytest.importorskip("h5py")
    assert main(["recover", str(outs[model]), "--fields", "--times", "0.5", "--quiet"]) == 0
    assert main(["report", str(outs[model]), "--no-pictures"]) == 0
    assert "nearest to failure is not" not in (outs[model] / "report.html").read_text()
