"""Claims about the arrays of a load set: xarray opens them, with the numbers of the tables."""

import numpy as np
import pytest

from turbine_fenicsx.load_sets.arrays import write_set_arrays
from turbine_fenicsx.load_sets.lifetime import SetFatigue
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.load_sets.situation import Situation
from turbine_fenicsx.records.statistics import ColumnStatistics
from turbine_fenicsx.study.plan import Run


def make_run(name, seed):
    return SetRun(Run(name, {}, None, ""), name[:3], 12.0, 0.1, "größer", seed)


RUNS = [make_run("1.2/a", 3), make_run("6.1/b", None), make_run("6.1/unfinished", None)]
RESULTS = {
    "1.2/a": [ColumnStatistics("x_[N]", 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)],
    "6.1/b": [
        ColumnStatistics("x_[N]", *np.arange(7.0, 13.0)),
        ColumnStatistics("y_[m]", *np.arange(13.0, 19.0)),
    ],
}
SITUATIONS = {"1.2": Situation(evaluates="fatigue"), "6.1": Situation()}


@pytest.mark.parametrize("loads", [("x_[N]", "z_[Nm]"), ()])
def test_xarray_opens_the_arrays(tmp_path, loads):
    xarray = pytest.importorskip("xarray")
    ranges = {name: 10.0 * (k + 1) for k, name in enumerate(loads)}
    slopes = {name: 4.0 for name in loads}
    fatigue = SetFatigue(slopes, {"1.2/a": ranges}, ranges, {}, {"1.2/a": 1e5})
    path = tmp_path / "set.nc"
    path.write_bytes(write_set_arrays(RUNS, SITUATIONS, RESULTS, fatigue))
    with xarray.open_dataset(path, engine="scipy") as found:
        assert found["run"].values.tolist() == ["1.2/a", "6.1/b"]
        assert found["variant"].values.tolist() == ["größer", "größer"]
        own = found.sel(run="6.1/b")
        assert float(own["largest"].sel(column="y_[m]")) == 17.0
        assert np.isnan(found["mean"].sel(run="1.2/a", column="y_[m]"))
        assert found["seed"].values.tolist()[0] == 3.0 and np.isnan(own["seed"])
        assert found["safety_factor"].values.tolist() == [1.0, 1.35]
        assert found["times_in_life"].values.tolist() == [1e5, 0.0]
        assert found["yaw_error"].units == "deg"
        assert not loads or found["load"].values.tolist() == list(loads)
        for name, value in ranges.items():
            assert float(found["equivalent_range"].sel(run="1.2/a", load=name)) == value
            assert np.isnan(own["equivalent_range"].sel(load=name))
            assert float(found["equivalent_range_of_life"].sel(load=name)) == value


def test_before_the_first_run_there_is_nothing():
    fatigue = SetFatigue({}, {}, {}, {}, {})
    assert write_set_arrays(RUNS, SITUATIONS, {}, fatigue) == b""
