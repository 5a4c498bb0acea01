"""Claims about densities and moduli that differ from cell to cell."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh

from turbine_fenicsx import (
    Gravity,
    KelvinVoigt,
    MooneyRivlin,
    NeoHooke,
    OrthotropicSVK,
    StVenantKirchhoff,
    TransverselyIsotropic,
    _compat,
    cell_field,
)
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

pytestmark = pytest.mark.parallel

E = tuple(ufl.as_vector(row) for row in np.eye(3).tolist())
LAWS = {
    "svk": lambda c: StVenantKirchhoff(c(1e4), c(5e3)),
    "neo_hooke": lambda c: NeoHooke(c(1e4), c(5e3)),
    "mooney_rivlin": lambda c: MooneyRivlin(c(2e3), c(5e2), c(2e4)),
    "kelvin_voigt": lambda c: KelvinVoigt(StVenantKirchhoff(c(1e4), c(5e3)), c(20.0), c(10.0)),
    "orthotropic": lambda c: OrthotropicSVK(
        young=(c(2e4), c(1.2e4), c(1e4)),
        shear=(c(4e3), c(5e3), c(6e3)),
        poisson=(c(0.2), c(0.3), c(0.25)),
        frame=E,
    ),
    "transversely_isotropic": lambda c: TransverselyIsotropic(
        c(4e4), c(1e4), c(5e3), c(0.3), c(0.4), E[0]
    ),
}


def box(comm, cell="hexahedron"):
    corners = [[0, 0, 0], [2, 0.5, 0.5]]
    return mesh.create_box(comm, corners, [4, 1, 1], getattr(mesh.CellType, cell))


def ends(cells, x1):
    return mesh.locate_entities_boundary(cells, 2, lambda x: np.isclose(x[0], x1))


def clamped(comm, cells, law, density, *more):
    beam = FlexibleBody("beam", cells, law, density)
    root = Coupling("root", beam, ends(cells, 0.0), None)
    return MultibodySystem(comm, [beam, root, Gravity(), *more])


def swing(system, steps=6, **options):
    """Balances after each step, and the last displacements."""
    simulation = Simulation(
        system, 0.02, steps * 0.02, stepper=EnergyMomentum(system, options=SolverOptions(**options))
    )
    last = simulation.run()
    simulation.stepper.destroy()
    b = last.balance
    numbers = [b.kinetic, b.strain, b.potential, *b.linear, *b.angular, last.energy_error]
    return np.array(numbers), last.state.u[0].array_r.copy()


@pytest.mark.parametrize("law", LAWS)
def test_a_uniform_field_is_a_constant(comm, law):
    """Compiled expressions differ, the results by round-off only."""
    cells = box(comm)

    def field(value):
        return cell_field(cells, lambda X: np.full(len(X), value))

    constant, u = swing(clamped(comm, cells, LAWS[law](lambda value: value), 500.0))
    same, v = swing(clamped(comm, cells, LAWS[law](field), field(500.0)))
    scale = np.max(np.abs(constant))
    assert constant[1] > 1e-3 * scale  # it bends
    assert np.allclose(same, constant, rtol=0, atol=1e-9 * scale)
    assert np.allclose(v, u, rtol=0, atol=1e-9)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_two_parts_of_one_body_are_two_bodies(comm, cell):
    """Mass, momentum, weight and energy of a field are those of bodies with a constant each."""
    corners = [[[0, 0, 0], [1, 0.5, 0.5]], [[1, 0, 0], [2, 0.5, 0.5]]]
    kind = getattr(mesh.CellType, cell)
    whole = box(comm, cell)
    halves = [mesh.create_box(comm, c, [2, 1, 1], kind) for c in corners]
    densities, shears = (300.0, 900.0), (2e3, 7e3)

    def pick(values):
        return cell_field(whole, lambda X: np.where(X[:, 0] < 1.0, *values))

    def motion(X):
        return np.stack([X[:, 1] ** 2, X[:, 0] * X[:, 2], 0.3 * X[:, 0]], axis=1)

    def balance(cells, density, shear):
        body = FlexibleBody("b", cells, StVenantKirchhoff(1e3, shear), density, velocity=motion)
        system = MultibodySystem(comm, [body, Gravity()])
        state = system.initial_state()
        (block,) = system.flexible_models
        state.u[0].array[:] = 0.1 * motion(block.positions).ravel()
        b = system.balance(state)
        numbers = [b.kinetic, b.strain, b.potential, *b.linear, *b.angular]
        return np.array([*numbers, comm.allreduce(block.nodal_mass.sum())])

    found = balance(whole, pick(densities), pick(shears))
    parts = sum(balance(*part) for part in zip(halves, densities, shears, strict=True))
    assert found[-1] == pytest.approx(0.25 * 1200.0, rel=1e-13)
    # tetrahedra of the two boxes are cut alike
    assert np.allclose(found, parts, rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize(
    ("law", "same_as"), [("orthotropic", StVenantKirchhoff), ("transversely_isotropic", NeoHooke)]
)
def test_constants_are_combined_cell_by_cell(comm, law, same_as):
    """An anisotropic law with isotropic constants is the isotropic one, in each cell its own."""
    cells = box(comm)

    def values(k):
        """Young's modulus, Poisson's ratio and the Lame constants."""
        E, nu = 1e4 * (1.0 + k), 0.2 + 0.05 * k
        return E, nu, E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu))

    young, nu, lam, mu = (
        cell_field(cells, lambda X, i=i: values(np.round(2.0 * X[:, 0] - 0.5) % 3)[i])
        for i in range(4)
    )
    if law == "orthotropic":
        general = OrthotropicSVK(young=(young,) * 3, shear=(mu,) * 3, poisson=(nu,) * 3, frame=E)
    else:
        general = TransverselyIsotropic(young, young, mu, nu, nu, E[0])
    energies = []
    for material in (general, same_as(lam, mu)):
        system = clamped(comm, cells, material, cell_field(cells, lambda X: 0.0 * X[:, 0] + 500.0))
        state, X = system.initial_state(), system.flexible_models[0].positions
        state.u[0].array[:] = 0.05 * np.stack([X[:, 0] ** 2, X[:, 1] * X[:, 0], X[:, 2]]).T.ravel()
        energies.append(system.balance(state).strain)
    assert energies[0] == pytest.approx(energies[1], rel=1e-9)


def test_a_soft_half_bends_and_energy_is_conserved(comm):
    """With the frozen factor as with the exact tangent."""
    cells = box(comm)
    shear = cell_field(cells, lambda X: np.where(X[:, 0] < 1.0, 3e4, 3e3))
    density = cell_field(cells, lambda X: np.where(X[:, 0] < 1.0, 800.0, 200.0))
    law = StVenantKirchhoff(1e4, shear)
    results = [swing(clamped(comm, cells, law, density), linear_solver=p) for p in ("frozen", "lu")]
    for numbers, _ in results:
        assert abs(numbers[-1]) < 1e-9 * numbers[1]
    assert np.allclose(results[0][1], results[1][1], rtol=0, atol=1e-9)


def test_values_are_those_of_the_cells(comm):
    cells = box(comm)
    n = cells.topology.index_map(3).size_local
    field = cell_field(cells, np.arange(n) + 10.0 * comm.rank)
    dofs = _compat.dofs_of_cells(field.function_space)[:n, 0]
    assert np.array_equal(field.x.array[dofs], np.arange(n) + 10.0 * comm.rank)
    by_place = cell_field(cells, lambda X: X[:, 0])
    total = comm.allreduce(float(by_place.x.array[dofs].sum()))
    assert total == pytest.approx(0.25 + 0.75 + 1.25 + 1.75)


def test_rows_of_values_are_the_components_of_a_vector(comm):
    cells = box(comm)
    rows = cell_field(cells, lambda X: X[:, [0, 2]] ** [1, 2])
    dx = ufl.dx(domain=cells, metadata={"quadrature_degree": 2})
    for k, expected in enumerate((0.25 + 0.75 + 1.25 + 1.75, 4 * 0.25**2)):
        form = fem.form(rows[k] * dx)
        assert comm.allreduce(fem.assemble_scalar(form)) == pytest.approx(0.125 * expected)
    short = np.zeros((cells.topology.index_map(3).size_local, 2 + comm.rank))
    if comm.size > 1:
        with pytest.raises(ValueError, match="rows of a cell field differ in length between ranks"):
            cell_field(cells, short)


def test_mistakes_are_refused_in_a_sentence(comm):
    cells = box(comm)
    with pytest.raises(ValueError, match=r"a value for each of the \d+ cells of this rank"):
        cell_field(cells, np.ones(99))
    with pytest.raises(ValueError, match="values of a cell field must be finite"):
        cell_field(cells, lambda X: np.where(X[:, 0] > 1.5, np.nan, 1.0))
    with pytest.raises(ValueError, match="density must be a number, or a field made by cell_field"):
        FlexibleBody("b", cells, StVenantKirchhoff(1.0, 1.0), np.ones(4))
    with pytest.raises(ValueError, match="first lame must be constant in each cell, as cell_field"):
        V = _compat.vector_space(cells, 1)
        StVenantKirchhoff(fem.Function(V), 1.0)
    mixed = cell_field(cells, lambda X: X[:, 0] - 1.0)
    with pytest.raises(ValueError, match=r"density of .* 'b' must be positive, got -0.75 to 0.75"):
        FlexibleBody("b", cells, StVenantKirchhoff(1.0, 1.0), mixed)
    with pytest.raises(ValueError, match=r"not positive definite: shear modulus -0.75 to 0.75 Pa"):
        NeoHooke(1.0, mixed)
    with pytest.raises(ValueError, match="not positive definite: Young's moduli"):
        OrthotropicSVK(young=(1.0, mixed, 1.0), shear=(1.0,) * 3, poisson=(0.0,) * 3, frame=E)
    with pytest.raises(ValueError, match="not positive definite: bulk modulus"):
        MooneyRivlin(1.0, 1.0, mixed)
    with pytest.raises(ValueError, match=r"shear viscosity must not be negative, got -0\.75 to"):
        KelvinVoigt(StVenantKirchhoff(1.0, 1.0), mixed)
    foreign = cell_field(box(comm), lambda X: X[:, 0] + 1.0)
    body = FlexibleBody("b", cells, StVenantKirchhoff(1.0, 1.0), foreign)
    with pytest.raises(ValueError, match="a cell field of 'b' was made for the mesh of another"):
        MultibodySystem(comm, [body])
