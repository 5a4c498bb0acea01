"""Steps that any user may ask for: tiny loads, no carriers, any linear solver, large strains."""

from mpi4py import MPI

import numpy as np
import pytest
from beams import LAWS, beam, free_machine
from dolfinx import mesh
from runs import Record, assert_constraints_hold, assert_energy_is_balanced, comm, run
from scipy.optimize import minimize

from turbine_fenicsx import (
    Coupling,
    EnergyMomentum,
    FlexibleBody,
    Gravity,
    JointTorque,
    MultibodySystem,
    Revolute,
    RigidBody,
    Simulation,
    SolverOptions,
    StVenantKirchhoff,
)
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine


def driven_beam(torque):
    """A hub on a bearing with a beam, at rest, without gravity."""
    hub = RigidBody("hub", 300.0, (30.0, 40.0, 50.0))
    body, root = beam(LAWS["st_venant_kirchhoff"](), "hexahedron", 1)
    spin = Revolute("spin", None, hub, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    parts = [
        hub,
        body,
        Coupling("root", body, root, hub),
        spin,
        JointTorque("torque on spin", "spin", 1.0, torque),
    ]
    return MultibodySystem(comm, parts)


@pytest.mark.parametrize("name", ["frozen", "lu"])
@pytest.mark.parametrize("peak", [1e3, 1.0, 1e-3])
def test_load_may_begin_gently(peak, name):
    # A torque that starts as t^4 from rest. Its first steps are so small that the round-off of the
    # elastic forces, eps times the stiffness, exceeds 1e-9 of the inertia forces.
    system = driven_beam(lambda t: peak * np.sin(np.pi * t / 0.4) ** 4 if t < 0.4 else 0.0)
    r = run(system, 0.005, 0.5, linear_solver=name)
    assert_constraints_hold(r)
    # The smallest motion is 1e-7 m, 1e9 units in the last place of a position of 4 m, so that its
    # energy of 5e-11 J has an error of some 1e-9; the others are far better.
    assert_energy_is_balanced(r, 0.4, 1e-7)


@pytest.mark.parametrize("name", ["frozen", "iterative", "lu", "monolithic"])
def test_beam_may_be_clamped_to_the_ground(name):
    body, root = beam(LAWS["st_venant_kirchhoff"](), "hexahedron", 1)
    parts = [body, Coupling("wall", body, root, None), Gravity((0.0, -1.0, 0.0))]
    r = run(MultibodySystem(comm, parts), 0.02, 0.6, linear_solver=name)
    assert_constraints_hold(r)
    # Solver accuracy, see test_conservation.py; energies here are differences of a potential that
    # is measured from the origin.
    assert_energy_is_balanced(r, 0.0, 1e-11)
    assert r.strain[-1] > 0.01 * np.max(np.abs(r.potential))


@pytest.mark.parametrize("law", LAWS)
def test_linear_solvers_agree(law):
    runs = [
        run(free_machine(law, "hexahedron", 1), 0.02, 0.4, linear_solver=p)
        for p in ("monolithic", "lu", "frozen", "iterative")
    ]
    reference = runs[0]
    for other in runs[1:]:
        # All solve the same equations to 1e-12; 20 steps of this motion amplify differences by
        # less than a hundred.
        assert np.max(np.abs(other.q - reference.q)) < 1e-9
        assert np.max(np.abs(other.total - reference.total)) < 1e-9 * reference.largest_energy


def worst_residual(system, dt, end, name):
    """Largest relative residual that a step of a run ends with."""
    worst = []

    class Residuals(Record):
        def observe(self, snapshot):
            worst.append(snapshot.report.residual if snapshot.report else 0.0)

    stepper = EnergyMomentum(system, options=SolverOptions(linear_solver=name))
    simulation = Simulation(system, dt, end, [Residuals()], stepper)
    simulation.run()
    stepper.destroy()
    return max(worst)


# Quasi-Newton iterations may gain less than a factor of two at times; a step that ends there is not
# converged. Round-off is what the exact tangent comes to rest at.


@pytest.mark.parametrize(
    ("law", "peak"),
    [("neo_hooke", 4000.0), ("neo_hooke", 6000.0), ("transversely_isotropic", 6000.0)],
)
def test_slow_convergence_of_a_beam_is_not_taken_for_round_off(law, peak):
    system = free_machine(law, "hexahedron", 2, peak=peak)
    # the tolerance is 1e-12; five times that leaves room for round-off proper
    assert worst_residual(system, 0.02, 0.6, "frozen") < 5e-12


def test_slow_convergence_of_a_turbine_is_not_taken_for_round_off():
    case = Case.parse(
        {
            "material": {"law": "st_venant_kirchhoff"},
            "mesh": {"elements": [1, 1, 6], "degree": 2},
            "loads": {"rotor_torque": -3.6e7, "duration": 0.32, "gravity": 0.0},
        }
    )
    exact, frozen = (
        worst_residual(build_turbine(case, comm).system, 0.02, 0.64, p) for p in ("lu", "frozen")
    )
    # measured 2e-11 and 8e-10
    assert frozen < 5.0 * exact


def test_strain_energy_of_quadratic_tetrahedra_is_never_negative():
    # W of St. Venant-Kirchhoff is not negative for any C, so neither may its integral be, however
    # wild the displacement: a quadrature rule with a negative weight has states of large strain
    # and negative energy, which a conserving scheme then finds.
    cube = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, mesh.CellType.tetrahedron)
    block = FlexibleModel(FlexibleBody("cube", cube, StVenantKirchhoff(0.8, 0.4), 1.0, degree=2))
    u, force = (block.new_vector() for _ in range(2))

    def energy(x):
        u.array[:] = x
        return block.strain_energy(u)

    def gradient(x):
        u.array[:] = x
        block.static_forces(u, np.zeros(3), 0.0, force)
        return force.array.copy()

    rng = np.random.default_rng(1)
    starts = 0.7 * rng.normal(size=(3, u.array.size))
    lowest = [minimize(energy, x, jac=gradient, method="BFGS").fun for x in starts]
    # the minimum is zero, at rigid motions; round-off of unit strains is 1e-16
    assert min(lowest) > -1e-12
