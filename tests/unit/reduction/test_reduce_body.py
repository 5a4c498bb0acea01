"""Claims about bases: functions, interfaces, what is refused; and their files."""

from dataclasses import replace

import numpy as np
import pytest
import ufl
from dolfinx import mesh
from reduced_beams import (
    COMM,
    LAME,
    SIZE,
    beam,
    clamped,
    clamped_basis,
    facets_at,
    free_basis,
)

from turbine_fenicsx import (
    Coupling,
    FlexibleBody,
    MultibodySystem,
    NeoHooke,
    PointForce,
    ReducedBody,
    RigidBody,
    StVenantKirchhoff,
    equilibrium,
    modes,
    read_basis,
    reduce_body,
    write_basis,
)
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.reduction.basis_functions import BasisFunctions
from turbine_fenicsx.reduction.gathered_body import gather_body
from turbine_fenicsx.reduction.interfaces import find_origins
from turbine_fenicsx.reduction.long_axis import LongAxis
from turbine_fenicsx.reduction.vector_fields import HeldBody
from turbine_fenicsx.system.flexible_model import FlexibleModel

pytestmark = pytest.mark.parallel


def test_functions_are_zero_on_interfaces_and_orthonormal():
    basis = clamped_basis()
    free = basis.functions[:, 4:]
    assert free.shape[1] == 18
    assert np.max(np.abs(free[basis.surface_of == 0])) == 0.0
    mass = basis.mass[4:, 4:] / basis.mass[0, 0]
    assert np.allclose(mass, np.eye(18), atol=1e-10)
    assert basis.mass[0, 0] == pytest.approx(1000.0 * np.prod(SIZE), rel=1e-12)


def test_responses_hold_what_modes_leave():
    """They have no energy in common with them, and the largest come first."""
    model = FlexibleModel(beam())
    whole = gather_body(model, False)
    root = np.flatnonzero(whole.positions[:, 2] < 1e-9)

    def check():
        axis = LongAxis(whole.positions, whole.mass.diagonal(), np.zeros(3))
        held = HeldBody(whole, [root], np.zeros((1, 3)), axis)
        squares, shapes = held.modes(4)
        fields = np.array(held.responses(5, squares, shapes)).reshape(5, -1)
        held.destroy()
        energies = fields @ (whole.stiffness @ fields.T)
        shared = shapes.reshape(4, -1) @ (whole.stiffness @ fields.T)
        sizes = np.sqrt(np.outer(squares, np.diag(energies)))
        assert np.max(np.abs(shared) / sizes) < 1e-9
        assert np.all(np.diff(np.diag(energies)) < 0.0)

    on_rank0(COMM, check)


def test_functions_of_a_free_body_are_none_of_its_affine_motions():
    basis = free_basis()
    assert np.allclose(basis.mass[:4, 4:], 0.0, atol=1e-9 * basis.mass[0, 0])
    assert not np.any(basis.surface_of >= 0)


def between_two(count=30):
    """A beam held at both ends, and its basis."""
    body = beam()
    ends = [
        Coupling(f"end {k}", body, facets_at(body, z), None) for k, z in enumerate((0.0, SIZE[2]))
    ]
    return body, ends, reduce_body(MultibodySystem(COMM, [body, *ends]), body, 2, count, loads=())


def test_functions_of_two_interfaces_move_the_body_in_any_affine_way():
    _, _, basis = between_two()
    rng = np.random.default_rng(0)
    A, t = rng.standard_normal((3, 3)), rng.standard_normal(3)
    z = np.zeros((basis.functions.shape[1], 3))
    for s, origin in enumerate(basis.origins):
        z[4 * s], z[4 * s + 1 : 4 * s + 4] = t + A @ origin, A.T
    assert np.allclose(basis.functions @ z, t + basis.points @ A.T, atol=1e-12)
    assert np.max(np.abs(basis.strain_vectors @ (basis.vectors @ A.T))[3:]) < 1e-12


def test_a_body_between_two_interfaces_bends_when_one_of_them_moves():
    """Modes with the tip free need the static shapes; the tip is held by a light rigid body."""
    body, _, basis = between_two()

    def system(b):
        tip = RigidBody("tip", 5.0, (0.1, 0.1, 0.1), position=(0.0, 0.0, SIZE[2]))
        root = Coupling("end 0", b, facets_at(body, 0.0), None)
        return MultibodySystem(
            COMM, [b, tip, root, Coupling("end 1", b, facets_at(body, SIZE[2]), tip)]
        )

    full, reduced = (modes(system(b), count=3) for b in (body, ReducedBody("r", body, basis)))
    for a, b in zip(full.modes, reduced.modes, strict=True):
        assert b.frequency == pytest.approx(a.frequency, rel=2e-3)


def test_a_rigid_motion_is_one_of_the_points_and_directors_alone():
    whole = gather_body(FlexibleModel(beam()), True)
    X = whole.positions
    ends = [np.flatnonzero(np.abs(X[:, 2] - z) < 1e-9) for z in (0.0, SIZE[2])]
    R, t = rotation_about((1.0, 2.0, 3.0), 1.2), np.array([1.0, -2.0, 0.5])

    def check():
        functions = BasisFunctions(whole, ends, find_origins(whole, ends), 24)
        functions.add_linear(1, True)
        z = functions.coordinates(t + X @ R.T - X)
        for s, origin in enumerate(functions.origins):
            assert np.allclose(z[4 * s], t + R @ origin - origin, atol=1e-12)
            assert np.allclose(z[4 * s + 1 : 4 * s + 4], R.T - np.eye(3), atol=1e-12)
        assert np.max(np.abs(z[8:])) < 1e-12

    on_rank0(COMM, check)


def test_forces_on_one_interface_move_the_body_as_the_full_one():
    """Its directors turn with it, also that which is normal to a plane surface."""
    body, _, basis = between_two()

    def head(b):
        tip = RigidBody("tip", 5.0, (0.1, 0.1, 0.1), position=(0.0, 0.0, SIZE[2]))
        root = Coupling("end 0", b, facets_at(body, 0.0), None)
        end = Coupling("end 1", b, facets_at(body, SIZE[2]), tip)
        push = PointForce("push", tip, point=(0.1, 0.0, SIZE[2]), force=(1e-4, 2e-4, 1e-4))
        start = np.array([0.0, 0.0, SIZE[2], *np.eye(3).ravel()])
        return equilibrium(MultibodySystem(COMM, [b, tip, root, end, push])).q - start

    full, reduced = head(body), head(ReducedBody("r", body, basis))
    assert np.max(np.abs(full)) > 1e-7
    assert np.max(np.abs(reduced - full)) < 1e-6 * np.max(np.abs(full))


def test_quadratic_tetrahedra_can_be_reduced():
    box = mesh.create_box(
        COMM, [[-0.1, -0.1, 0.0], [0.1, 0.1, 2.0]], [1, 1, 5], mesh.CellType.tetrahedron
    )
    body = FlexibleBody("beam", box, StVenantKirchhoff(*LAME), 1000.0, degree=2)
    basis = reduce_body(clamped(body), body, 2, 9, loads=())
    full = modes(clamped(body), count=2)
    reduced = modes(clamped(ReducedBody("r", body, basis)), count=2)
    for a, b in zip(full.modes, reduced.modes, strict=True):
        assert b.frequency == pytest.approx(a.frequency, rel=1e-8)


def test_what_cannot_be_reduced_is_refused():
    body = beam()
    with pytest.raises(ValueError, match="flexible body 'beam' is not"):
        reduce_body(MultibodySystem(COMM, []), body)
    rubber = replace(body, material=NeoHooke(*LAME))
    with pytest.raises(ValueError, match="law NeoHooke of 'beam' is not quadratic in the strain"):
        reduce_body(MultibodySystem(COMM, [rubber]), rubber)
    reduced = ReducedBody("r", body, clamped_basis())
    with pytest.raises(ValueError, match="'r' is reduced already"):
        reduce_body(MultibodySystem(COMM, [reduced]), reduced)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"modes": -1}, "modes must be a whole number, zero or more, got -1"),
        ({"functions": 2.5}, "functions must be a whole number"),
        ({"modes": 4, "functions": 9}, "functions must be three or more for each of 4 modes"),
        ({"modes": 100, "functions": 300}, "modes must be fewer than"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(numbers, words):
    box = mesh.create_box(COMM, [[0.0] * 3, [1.0, 1.0, 2.0]], [1, 1, 2], mesh.CellType.hexahedron)
    body = FlexibleBody("b", box, StVenantKirchhoff(*LAME), 1.0)
    with pytest.raises(ValueError, match=words):
        reduce_body(clamped(body), body, **numbers)


def test_a_small_mesh_has_fewer_functions_than_wanted(caplog):
    box = mesh.create_box(COMM, [[0.0] * 3, [1.0, 1.0, 2.0]], [1, 1, 2], mesh.CellType.hexahedron)
    body = FlexibleBody("b", box, StVenantKirchhoff(*LAME), 1.0)
    basis = reduce_body(clamped(body), body, 0, 48, loads=())
    assert basis.functions.shape[1] == 4 + 8  # one for each free node
    if COMM.rank == 0:
        assert "the basis of 'b' has 8 functions, as more are none: 48 were wanted" in caplog.text


class Prestressed:
    """A law that has a stress at rest in a part of the body."""

    quadratic = True

    def strain_energy(self, C, parameter):
        E = 0.5 * (C - ufl.Identity(3))
        x = ufl.SpatialCoordinate(beam().mesh)
        rest = ufl.conditional(ufl.gt(x[2], 3.5), 1e6, 0.0)
        return 1e7 * ufl.inner(E, E) + rest * ufl.tr(E)


@pytest.mark.filterwarnings("ignore:law Prestressed:turbine_fenicsx.ModelWarning")
def test_a_stress_at_rest_in_a_few_cells_is_refused_on_all_ranks():
    body = replace(beam(), material=Prestressed())
    with pytest.raises(ValueError, match="law Prestressed of 'beam' has a stress at rest"):
        reduce_body(clamped(body), body)


def two_bricks():
    """Two bricks that do not touch, in one mesh; facets at their roots."""
    box = mesh.create_box(COMM, [[0.0] * 3, [0.2, 0.2, 2.0]], [1, 1, 13], mesh.CellType.hexahedron)
    middle = mesh.locate_entities(box, 3, lambda X: np.isclose(X[2], 1.0, atol=0.09))
    keep = np.setdiff1d(np.arange(box.topology.index_map(3).size_local), middle)
    cells = mesh.create_submesh(box, 3, keep.astype(np.int32))[0]
    body = FlexibleBody("bricks", cells, StVenantKirchhoff(*LAME), 1000.0)
    return body, [facets_at(body, z) for z in (0.0, 2.0)]


@pytest.mark.skipif(COMM.size > 1, reason="the mesh is made of one rank's cells")
def test_each_part_of_a_mesh_is_held_by_something():
    body, (low, high) = two_bricks()
    first, second = (Coupling(f"{k}", body, facets, None) for k, facets in enumerate((low, high)))
    with pytest.raises(ValueError, match="the mesh has 2 parts that do not touch, and couplings"):
        reduce_body(MultibodySystem(COMM, [body, first]), body, 2, 9)
    system = MultibodySystem(COMM, [body, first, second])
    basis = reduce_body(system, body, 4, 18, loads=())
    reduced = ReducedBody("r", body, basis)
    held = [Coupling(c.name, reduced, c.facets, None) for c in (first, second)]
    full, found = modes(system, count=4), modes(MultibodySystem(COMM, [reduced, *held]), count=4)
    for a, b in zip(full.modes, found.modes, strict=True):
        assert b.frequency == pytest.approx(a.frequency, rel=1e-8)


@pytest.fixture
def folder(tmp_path):
    """A folder that all ranks know."""
    return COMM.bcast(tmp_path)


def written(folder, basis):
    path = folder / "basis.npz"
    on_rank0(COMM, lambda: write_basis(path, basis))
    return path


def test_a_basis_survives_its_file(folder):
    basis = clamped_basis(law="viscous")
    read = read_basis(written(folder, basis), beam("viscous"))
    for name in ("points", "functions", "mass", "strain_factor", "viscosity", "surface_of"):
        assert np.array_equal(getattr(read, name), getattr(basis, name))
    with pytest.raises(ValueError, match="read-only"):
        read.mass[0, 0] = 1.0


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (lambda: beam(cells=(1, 2, 9)), "the mesh has 18 cells, and that of the basis 16"),
        (lambda: beam(degree=2), "the mesh has 255 nodes, and that of the basis 54"),
        (lambda: replace(beam(), density=1001.0), "the cells have another density"),
        (
            lambda: replace(beam(), material=StVenantKirchhoff(LAME[0], 1.0001 * LAME[1])),
            "the cells have another stiffness",
        ),
        (lambda: beam("viscous"), "the cells have another viscosity"),
    ],
)
def test_a_file_of_another_body_is_refused(folder, other, words):
    path = written(folder, clamped_basis())
    with pytest.raises(ValueError, match=f"'.*basis.npz' is not a basis of 'beam', {words}"):
        read_basis(path, other())


def test_a_file_that_is_none_is_refused(folder):
    path = written(folder, clamped_basis())
    content = COMM.bcast(path.read_bytes() if COMM.rank == 0 else None)

    def refuse(content, words):
        on_rank0(COMM, lambda: path.write_bytes(content))
        with pytest.raises(ValueError, match=words):
            read_basis(path, beam())

    for cut in (0, 100, len(content) // 2, len(content) - 30):
        refuse(content[:cut], "is not a basis of a reduced body, or damaged")
    flipped = bytearray(content)
    flipped[len(content) // 2] ^= 1
    refuse(bytes(flipped), "is not a basis of a reduced body, or damaged")
    refuse(b"points,functions\n1,2\n", "is not a basis of a reduced body, or damaged")


def test_a_file_with_wrong_arrays_is_refused(folder):
    basis = clamped_basis()
    path = folder / "basis.npz"

    def refuse(words, **changes):
        arrays = {name: np.array(getattr(basis, name)) for name in basis.__dataclass_fields__}
        arrays |= {"version": np.array(2)} | changes
        on_rank0(COMM, lambda: np.savez(path, **arrays))
        with pytest.raises(ValueError, match=words):
            read_basis(path, beam())

    refuse("is a basis of version 3, and this is version 2", version=np.array(3))
    refuse("is damaged: mass of a basis must have the shape", mass=np.eye(3))
    refuse("is damaged: masses of a basis must be finite", masses=np.full(54, np.nan))
    refuse("is damaged: functions of a basis has the shape", functions=np.zeros(7))
    refuse("is damaged: a basis of 22 functions cannot have 6", origins=np.zeros((6, 3)))
    refuse("is not a basis of a reduced body", mass=np.array([None], dtype=object))
    arrays = {"version": np.array(2)}
    on_rank0(COMM, lambda: np.savez_compressed(path, **arrays))
    with pytest.raises(ValueError, match="is not a basis of a reduced body"):
        read_basis(path, beam())


def test_a_basis_of_one_rank_serves_several(folder):
    """Nodes stand in another order there: interfaces are found by position."""
    basis = clamped_basis()
    path = written(folder, basis)
    state = equilibrium(clamped(ReducedBody("r", beam(), read_basis(path, beam()))))
    assert np.all(np.isfinite(state.u[0].array_r))
