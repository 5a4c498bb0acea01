"""Claims about the air on sections: compiled code does as NumPy does."""

from itertools import product

import numpy as np
import pytest

from turbine_fenicsx import _compat
from turbine_fenicsx.forces.section_loads import SectionMotion
from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.wind.pitch_rate import PitchRate
from turbine_fenicsx.wind.polar import Polar, PolarTable
from turbine_fenicsx.wind.section_air import (
    AirState,
    CompiledAir,
    NumpyAir,
    Properties,
    Rotation,
    compile_section_air,
)
from turbine_fenicsx.wind.shed_wake import ShedWake
from turbine_fenicsx.wind.stall import OeyeStall, tabulate_separation

N = 12
ROUND_OFF = 1e-13
SIGMA = np.linspace(0.0, 1.0, N)
STATE = AirState(np.linspace(0.0, 1.0, N), 20.0 * np.random.default_rng(3).standard_normal((N, 3)))
ROTOR = Rotation(np.array([1.0, -2.0, 100.0]), np.array([0.98, 0.0, np.sqrt(1 - 0.98**2)]), 0.7)


def properties(with_stall, with_turning, with_shedding):
    """Two aerofoils along three blades of four stations."""
    angle = np.radians(np.linspace(-180.0, 180.0, 73))
    polars = [
        Polar(f"p{k}", angle, lift * np.sin(angle), 0.01 + np.sin(angle) ** 2, -0.1 * np.sin(angle))
        for k, lift in enumerate((5.0, 4.0))
    ]
    table, chord = PolarTable([polars[k] for k in (0, 0, 1, 1)]), np.linspace(5.0, 1.0, N)
    coefficients = tabulate_separation(table, 3) if with_stall else table.tabulate(table.values, 3)
    return Properties(
        coefficients,
        chord,
        np.linspace(2.0, 3.0, N),
        1.225,
        OeyeStall() if with_stall else None,
        PitchRate(SIGMA, chord, 0.25) if with_turning else None,
        ShedWake(SIGMA, chord) if with_shedding else None,
    )


def sections():
    rng = np.random.default_rng(1)
    axes = np.array([rotation_about(rng.standard_normal(3), 2.0) for _ in range(N)])
    position = ROTOR.centre + 50.0 * rng.standard_normal((N, 3))
    velocity, omega = 30.0 * rng.standard_normal((N, 3)), rng.standard_normal((N, 3))
    motion = SectionMotion(position, axes, velocity, omega, position)
    return motion, np.concatenate([rng.standard_normal((N, 3, 1)), axes], axis=2)


@pytest.fixture(params=list(product((False, True), repeat=3)))
def both(request):
    of = properties(*request.param)
    compiled = compile_section_air(of)
    assert isinstance(compiled, CompiledAir)
    return compiled, NumpyAir(of)


def check_same(found, wanted):
    for a, b in zip(found, wanted, strict=True):
        assert np.allclose(a, b, rtol=0.0, atol=ROUND_OFF * np.max(np.abs(b), initial=1.0))


def test_places_are_those_of_numpy(both):
    (found, radius), (wanted, wanted_radius) = (air.place(*sections(), ROTOR) for air in both)
    check_same([*found, radius], [*wanted, wanted_radius])
    assert found._fields == wanted._fields


@pytest.mark.parametrize("state", [AirState(), STATE])
@pytest.mark.parametrize("duration", [0.025, np.inf])
def test_loads_are_those_of_numpy(both, state, duration):
    places, _ = both[1].place(*sections(), ROTOR)
    wind, w = np.random.default_rng(2).standard_normal((2, N, 3))
    given = (20.0 * wind, 5.0 * w[:, :2], state._replace(duration=duration))
    check_same(*(air.find_loads(places, *given) for air in both))
    own, _ = both[0].place(*sections(), ROTOR)
    check_same(both[0].find_loads(own, *given), both[1].find_loads(places, *given))


@pytest.mark.parametrize("state", [AirState(), STATE])
def test_loads_in_the_plane_are_those_of_numpy_at_all_angles(both, state):
    angle = np.linspace(-np.pi, np.pi, N)
    p = np.stack([30.0 * np.cos(angle), 30.0 * np.sin(angle), angle])
    p[:, 3] = 0.0  # without any flow
    check_same(*(air.find_plane_loads(p, state._replace(duration=0.1)) for air in both))


def test_a_flow_that_is_not_a_number_gives_no_load(both):
    p = np.ones((3, N))
    p[0, 2] = np.nan
    loads, *_ = both[0].find_plane_loads(p, AirState())
    assert np.all(np.isnan(loads[:2, 2]))
    assert np.all(np.isfinite(loads[:, 3]))


def test_without_a_compiler_numpy_does_it(monkeypatch):
    def fail(*arguments):
        raise CompilationError("no compiler")

    monkeypatch.setattr(_compat, "compile_c", fail)
    assert isinstance(compile_section_air(properties(True, True, True)), NumpyAir)
