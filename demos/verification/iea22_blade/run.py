"""The blade of the IEA 22 MW turbine from its windIO file, as a hollow solid.

A blade of 138 m and 82 t with twelve layers in its shell and three shear webs becomes quadratic
hexahedra, one through the wall, whose moduli are those of the laminate there. It is clamped at its
root, at rest. The reference is a beam with the 6 by 6 matrices of its sections that the same file
lists, from other programs: what is compared is the whole way from layers to motion. The beam has
200 elements; twice as many change its frequencies by 1e-4 and less.

Meshes have 20, 40 and 80 elements along the span and 24, 32 and 48 around a section, without those
of the webs. Differences between them are no powers of the element size: with each mesh, places
where layers begin and end fall otherwise into cells. So there is no order, and the change from the
second to the third mesh is shown in its place.

With the moduli of a uniform wall all frequencies are lower than those of the beam, those of
bending edgewise most. With the bending stiffness of each laminate as well (A, B and D,
"laminate"), these come nearer by up to 1 %, and so does torsion. Thin panels with foam bend a
little when a section shears. The root has a part in what is left. Layers that end within metres
make the section at 5 % of the span softer than the file's matrices, by up to 17 %; from 20 % on
they agree. A beam whose sections are integrated from the solid has frequencies lower by up to 0.4
%.

The fourth flapwise mode is not one alone: it twists as much as it bends. Sections are those of the
mesh with 40 elements, integrated with Young's modulus along the span;
bending stiffness is that about the centre of stretch. The mass of all layers is that on the outer
surface: integrated from the file's curves alone, and summed over the laminates of all cells.
"""

from functools import cache

from mpi4py import MPI

from published import Row, load, references

from turbine_fenicsx import equilibrium, modes
from turbine_fenicsx.windio import find_turbine_file, read_turbine

FILE = "IEA-22-280-RWT.yaml"
MESHES = ((20, 24), (40, 32), (80, 48))  # elements along the span and around
MIDDLE = MESHES[1]
STATIONS = (0.2, 0.32, 0.44, 0.56, 0.68, 0.8)
MODES = ("flap_1", "edge_1", "flap_2", "edge_2", "flap_3", "edge_3", "flap_4", "torsion_1")
SECTION = {
    "mass per length": ("kg/m", 1.0),
    "EA": ("MN", 1e6),
    "EI edgewise": ("MN m²", 1e6),
    "EI flapwise": ("MN m²", 1e6),
}

SLOW = True


@cache
def blade():
    """The blade of the file and its matrices, as a beam wants them."""
    turbine = read_turbine(find_turbine_file(FILE))
    return turbine.blade, load("iea22_blade", "exact").blade_of_file(turbine)


def solve_beam(elements=200):
    """The references."""
    beam = load("iea22_blade", "exact").make_beam(blade()[1], elements)
    x, y = (beam.bend(beam.weight(k))[-1, k] for k in (0, 1))
    frequencies = dict(zip(MODES, beam.frequencies(len(MODES))[0], strict=True))
    return {"mass": beam.mass, "centre": beam.centre[2], "tip_x": x, "tip_y": y} | frequencies


def solve(elements, moments=False, weight=True, comm=MPI.COMM_WORLD):
    """The same quantities of the solid.

    Args:
        elements: Along the span and around.
        moments: Whether walls have the bending stiffness of their laminates.
        weight: Whether it is bent by its weight too.
        comm: Communicator.
    """
    solid = load("iea22_blade", "solid").make_solid(comm, blade()[0], elements, moments)
    system = solid.system()
    model = system.flexible_models[0]
    mass = comm.allreduce(model.nodal_mass.sum())
    centre = comm.allreduce(model.nodal_mass @ model.positions[:, 0]) / mass
    found = {"mass": mass, "centre": centre - blade()[0].hub_radius}
    vibrations = modes(system, count=len(MODES)).modes
    found |= {name: mode.frequency for name, mode in zip(MODES, vibrations, strict=True)}
    for k, name in enumerate(("tip_x", "tip_y")) if weight else ():
        bent = solid.system(k)
        found[name] = solid.tip_displacement(bent, equilibrium(bent))[k]
    return found


def sections(elements=MIDDLE):
    """Rows of the sections at six stations, and of the mass of all layers."""
    solid, tools = (load("iea22_blade", name) for name in ("solid", "sections"))
    shape, beam = blade()
    mesh = solid.make_solid(MPI.COMM_SELF, shape, elements)
    step, rows = describe(elements), []
    for s in STATIONS:
        pairs = zip(tools.published_section(beam, s), tools.section(mesh, beam, s), strict=True)
        for (name, (unit, size)), pair in zip(SECTION.items(), pairs, strict=True):
            quantity = f"{name} at {100 * s:g} % of the span"
            rows.append(row(quantity, unit, *(x / size for x in pair), 0.02, step))
    layers, cells = tools.mass_of_layers(shape), tools.mass_of_cells(mesh)
    return [*rows, row("mass of all layers, on the outer surface", "kg", layers, cells, 1e-3, step)]


def main(meshes=MESHES):
    """Rows of the table."""
    expected = references("iea22_blade")
    runs = {describe(n): solve(n, weight=n != meshes[-1]) for n in meshes}
    laminate = f"{describe(meshes[1])}, laminate"
    runs[laminate] = solve(meshes[1], moments=True)
    rows = [
        Row(r.quantity, r.unit, r.value, run[name], r.tolerance, step)
        for name, r in expected.items()
        for step, run in runs.items()
        if name in run
    ]
    before, last = (runs[describe(n)] for n in meshes[1:])
    for name in MODES:
        quantity = f"{expected[name].quantity}, {meshes[1][0]} to {meshes[2][0]} elements"
        rows.append(row(quantity, "Hz", before[name], last[name], 5e-3, describe(meshes[2])))
    return rows + sections(meshes[1])


def row(quantity, unit, reference, found, tolerance, step):
    """A row whose reference has five digits and whose tolerance is relative."""
    rounded = float(f"{reference:.5g}")
    return Row(quantity, unit, rounded, float(found), tolerance * abs(rounded), step)


def describe(elements):
    """A mesh in words."""
    return f"{elements[0]} by {elements[1]} elements"
