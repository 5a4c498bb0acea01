"""Claims about turbulence that C code looks up: it is that of NumPy."""

import numpy as np
import pytest

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import CompilationError, InputError
from turbine_fenicsx.wind.compiled_turbulence import CompiledTurbulence, compile_turbulence
from turbine_fenicsx.wind.turbulence import TurbulenceField

PLANES, HEIGHTS, WIDTHS = 7, 5, 4


def field(kind, periodic, bottom):
    values = np.random.default_rng(0).uniform(-3e4, 3e4, (PLANES, HEIGHTS, WIDTHS, 3))
    return TurbulenceField(
        values.astype(kind),
        np.array([900.0, 1000.0, 1100.0]),
        np.array([-50.0, 0.0, 70.0]),
        dt=0.5,
        y=np.linspace(-30.0, 30.0, WIDTHS),
        z=bottom + np.linspace(0.0, 80.0, HEIGHTS),
        speed=9.0,
        periodic=periodic,
        lead=1.5,
    )


@pytest.mark.parametrize("kind", [np.int16, np.float32])
@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("bottom", [0.0, 20.0])
def test_everywhere_the_wind_is_that_of_numpy(kind, periodic, bottom):
    numpy = field(kind, periodic, bottom)
    compiled = compile_turbulence(numpy)
    assert isinstance(compiled, CompiledTurbulence)
    rng = np.random.default_rng(1)
    beyond = rng.uniform([-4.0, -50.0, -20.0], [4.0, 50.0, 130.0], (300, 3))
    corner = np.array([[0.0, numpy.y[-1], numpy.z[-1]], [0.0, numpy.y[0], numpy.z[0]]])
    lost = np.where(np.eye(3, dtype=bool), np.nan, 1.0)
    places = np.concatenate([beyond, corner, lost]).reshape(5, 61, 3)
    for time in (0.0, 0.7, 1.0) + periodic * (-4.0, 3.0, 1e4):
        found = compiled.velocity(places, time)
        with np.errstate(invalid="ignore"):
            wanted = numpy.velocity(places, time)
        assert np.allclose(found, wanted, rtol=0.0, atol=1e-12, equal_nan=True)
    assert np.isfinite(found[:, 0]).all()


def test_a_field_that_has_ended_is_told():
    compiled = compile_turbulence(field(np.int16, False, 20.0))
    with pytest.raises(InputError, match=r"the wind field lasts from -1\.5 to 1\.5 s"):
        compiled.velocity(np.zeros((4, 3)), 1.6)


def test_without_a_compiler_numpy_does_it(monkeypatch):
    def fail(*arguments):
        raise CompilationError("no compiler")

    monkeypatch.setattr(_compat, "compile_c", fail)
    given = field(np.int16, True, 20.0)
    assert compile_turbulence(given) is given
