"""Everything that differs between the DOLFINx releases 0.5.2 to 0.11 and their PETSc, and no more.

Differences are found by looking at what the installed release offers, never by its version number.
All other modules import these names from here.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from inspect import signature
from pathlib import Path
from typing import Any

from petsc4py import PETSc

import basix
import dolfinx.fem.petsc
import dolfinx.graph
import dolfinx.jit
import dolfinx.mesh
import ffcx.codegeneration.jit
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem, geometry
from dolfinx.io.utils import distribute_entity_data

from turbine_fenicsx.foundation import c_code, form_cache
from turbine_fenicsx.foundation.errors import CompilationError

# FFCx 0.5 sets up the root logger at import; its compiler lines are noise to everyone else.
for _handler in logging.getLogger().handlers:
    _handler.setLevel(logging.WARNING)


_REASONS = PETSc.SNES.ConvergedReason
NOT_A_NUMBER = int(
    _REASONS.DIVERGED_FUNCTION_NANORINF  # PETSc 3.25
    if hasattr(_REASONS, "DIVERGED_FUNCTION_NANORINF")
    else _REASONS.DIVERGED_FNORM_NAN
)
"""PETSc's reason to end a Newton iteration whose residual is not a number."""

_ALGEBRA = ["-fassociative-math", "-fno-math-errno", "-fno-signed-zeros", "-fno-trapping-math"]
_COMPILER_FLAGS = ["-O3", "-g0", *_ALGEBRA]


def _jit_options() -> tuple[str, Callable[[dict[str, Any]], dict[str, Any]]]:
    """Name of the argument with options of the compiler, and what adds to them those not given."""
    if hasattr(dolfinx.jit, "get_options"):
        return "jit_options", dolfinx.jit.get_options
    return "jit_params", dolfinx.jit.get_parameters


@contextmanager
def _form_cache() -> Iterator[list[Any]]:
    """Let DOLFINx compile by way of `form_cache`, in a separate folder below that of DOLFINx.

    Yields:
        A list of the Python modules that were made or loaded meanwhile.
    """
    original, look_up = dolfinx.jit.ffcx_jit, ffcx.codegeneration.jit.get_cached_module
    name, complete = _jit_options()
    modules: list[Any] = []

    def jit(comm: Any, ufl_object: Any, **options: Any) -> Any:
        given = options.get(name) or {}

        def compile_here(folder: Path, claim: form_cache.Claim) -> Any:
            def claim_first(form: str, *others: Any) -> Any:
                claim(form)
                return look_up(form, *others)

            options[name] = {**given, "cache_dir": folder, "timeout": form_cache.PATIENCE}
            ffcx.codegeneration.jit.get_cached_module = claim_first
            try:
                return original.__wrapped__(ufl_object, **options)
            finally:
                ffcx.codegeneration.jit.get_cached_module = look_up

        folder = complete(given)["cache_dir"] / "turbine_fenicsx" / "forms"
        result = form_cache.compile_on_all(comm, folder, compile_here)
        modules.append(result[1])
        return result

    dolfinx.jit.ffcx_jit = jit
    try:
        yield modules
    finally:
        dolfinx.jit.ffcx_jit = original


@_form_cache()
def vector_space(mesh: Any, degree: int) -> Any:
    """Continuous Lagrange space of vectors of R^3."""
    if hasattr(fem, "functionspace"):
        return fem.functionspace(mesh, ("Lagrange", degree, (3,)))
    return fem.VectorFunctionSpace(mesh, ("Lagrange", degree), dim=3)


@_form_cache()
def cellwise_space(mesh: Any, shape: tuple[int, ...] = (), degree: int = 0) -> Any:
    """Space of fields that are polynomials in each cell, by default constant, and may jump."""
    if hasattr(fem, "functionspace"):
        return fem.functionspace(mesh, ("DG", degree, shape))
    is_product = cell_name(mesh) in ("quadrilateral", "hexahedron")
    element = ("DQ" if degree and is_product else "DG", degree)
    if shape == ():
        return fem.FunctionSpace(mesh, element)
    if len(shape) == 2:
        return fem.TensorFunctionSpace(mesh, element, shape)
    return fem.VectorFunctionSpace(mesh, element, dim=shape[0])


@_form_cache()
def expression(expr: Any, space: Any) -> Any:
    """Compiled expression that can be interpolated into ``space``."""
    return fem.Expression(expr, interpolation_points(space))


def interpolation_points(space: Any) -> npt.NDArray[np.float64]:
    """Points of the reference cell where a Lagrange space has its nodes, shape (nodes, 3)."""
    points = space.element.interpolation_points
    found: npt.NDArray[np.float64] = points() if callable(points) else points
    return found


def quadrature(cell: str, exact: int) -> tuple[Any, Any]:
    """Points of the reference cell, shape (n, 3), and weights that integrate a degree exactly."""
    return basix.make_quadrature(getattr(basix.CellType, cell), exact)  # type: ignore[no-any-return]


def shape_functions(cell: str, degree: int, points: npt.NDArray[np.float64]) -> tuple[Any, Any]:
    """Lagrange shape functions at points of the reference cell.

    Args:
        degree: Of the shape functions.
        points: Shape (points, d), with the dimension d of the cell.

    Returns:
        Values, shape (points, nodes), and derivatives with respect to the coordinates of the
        reference cell, shape (points, nodes, d).
    """
    kind, variant = getattr(basix.CellType, cell), basix.LagrangeVariant.equispaced
    element = basix.create_element(basix.ElementFamily.P, kind, degree, variant)
    values, *derivatives = element.tabulate(1, points)[..., 0]
    return values, np.stack(derivatives, axis=-1)


def reference_facets(cell: str) -> npt.NDArray[np.float64]:
    """Corners of the facets of the reference cell, shape (facets, corners, 3)."""
    kind = getattr(basix.CellType, cell)
    return np.array([basix.geometry(kind)[corners] for corners in basix.topology(kind)[2]])


def dofs_of_cells(space: Any) -> npt.NDArray[np.int32]:
    """Block degrees of freedom of the local cells, shape (cells, nodes per cell)."""
    return _as_rows(space.dofmap.list, space.dofmap.dof_layout.num_dofs)


def _as_rows(table: Any, width: int) -> npt.NDArray[np.int32]:
    """An adjacency list or array of one row a cell as an array of shape (cells, width)."""
    if isinstance(table, np.ndarray):
        return table
    rows: npt.NDArray[np.int32] = table.array.reshape(-1, width)
    return rows


def assemble_vector(vector: PETSc.Vec, form: Any) -> None:
    """Assemble a linear form into a ghosted vector, owners' values complete afterwards."""
    with vector.localForm() as local:
        local.set(0.0)
    add_to_vector(vector, form)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)


def add_to_vector(vector: PETSc.Vec, form: Any) -> None:
    """Add a linear form to the values that this rank holds of a ghosted vector."""
    dolfinx.fem.petsc.assemble_vector(vector, form)


def values_of_rank(form: Any) -> npt.NDArray[np.float64]:
    """A linear form assembled over the cells of this rank alone, ghosts included."""
    return dolfinx.fem.assemble_vector(form).array  # type: ignore[no-any-return]


def assemble_matrix(matrix: PETSc.Mat, form: Any, add: bool = False) -> None:
    """Assemble a bilinear form into a matrix made by `create_matrix`, or add it to its values."""
    if not add:
        matrix.zeroEntries()
    dolfinx.fem.petsc.assemble_matrix(matrix, form)
    matrix.assemble()


def create_matrix(form: Any) -> PETSc.Mat:
    """Distributed matrix with the sparsity of a bilinear form."""
    return dolfinx.fem.petsc.create_matrix(form)


def mesh_of_arrays(
    comm: Any, cell: str, degree: int, points: Any, cells: Any, ranks: Any = None
) -> Any:
    """Distributed mesh of the nodes and cells that the ranks hold, in gmsh's order of nodes.

    Args:
        points: Coordinates of the nodes of this rank, shape (n, 3).
        cells: Nodes of its cells, counted over the ranks, shape (m, nodes per cell).
        ranks: Ranks of each of these cells and its neighbours, its own first, and where those of
            each start; None on all ranks if DOLFINx decides.
    """
    element = "e" if "e" in signature(dolfinx.mesh.create_mesh).parameters else "domain"
    more = {element: ufl.Mesh(_coordinate_element(cell, degree))}
    if ranks is not None:
        if "ghost_mode" in signature(dolfinx.mesh.create_mesh).parameters:
            more["ghost_mode"] = dolfinx.mesh.GhostMode.none  # 0.5 wants ghosts to drop them
        else:
            ranks = ranks[0][ranks[1][:-1]], np.arange(len(ranks[1]), dtype=np.int32)
        lists = _adjacency_list(*ranks)
        more["partitioner"] = lambda *_: getattr(lists, "_cpp_object", lists)
    return dolfinx.mesh.create_mesh(comm, cells=_from_gmsh(cell, cells), x=points, **more)


def tags_of_entities(mesh: Any, entity: str, nodes: Any, values: npt.NDArray[np.int32]) -> Any:
    """Tags of the cells or facets of a mesh made by `mesh_of_arrays`.

    Args:
        nodes: Their nodes in gmsh's order as they were handed to the mesh, on any rank.
        values: Number of each.
    """
    dim = dolfinx.cpp.mesh.cell_dim(dolfinx.cpp.mesh.to_type(entity))
    entities, values = distribute_entity_data(mesh, dim, _from_gmsh(entity, nodes), values)
    mesh.topology.create_connectivity(dim, 0)
    mesh.topology.create_connectivity(dim, mesh.topology.dim)
    return dolfinx.mesh.meshtags_from_entities(mesh, dim, _adjacency_list(entities), values)


def _adjacency_list(*rows: Any) -> Any:
    """Rows of an array, or their entries and where each starts, as DOLFINx' lists."""
    make = getattr(dolfinx.graph, "create_adjacencylist", None) or dolfinx.graph.adjacencylist
    return make(*rows)


def _from_gmsh(cell: str, nodes: Any) -> npt.NDArray[np.int64]:
    """Nodes of cells in gmsh's order, in that of DOLFINx."""
    order = dolfinx.cpp.io.perm_gmsh(dolfinx.cpp.mesh.to_type(cell), nodes.shape[1])
    return np.ascontiguousarray(nodes[:, order], dtype=np.int64)


def _coordinate_element(cell: str, degree: int) -> Any:
    """Element of the geometry of a mesh."""
    try:
        from basix import LagrangeVariant
        from basix.ufl import element  # from 0.7
    except ImportError:
        return ufl.VectorElement("Lagrange", ufl.Cell(cell, 3), degree, variant="equispaced")
    return element("Lagrange", cell, degree, LagrangeVariant.equispaced, shape=(3,))


def compile_form(form: Any) -> Any:
    """Compiled form.

    Unless the user has set compiler flags (dolfinx_jit_options.json), the compiler may use the laws
    of algebra: a seventh faster, and only round-off changes. No flag ties the code to one
    processor, because caches are shared; `form_cache.read_extra_flags` does for who asks.
    """
    return _compile_form(form)[0]


def compile_form_with_source(form: Any) -> tuple[Any, Path]:
    """Compiled form, and the file of its C code."""
    compiled, module = _compile_form(form)
    return compiled, Path(module.__file__).parent / f"{module.__name__}.c"


def _compile_form(form: Any) -> tuple[Any, Any]:
    """Compiled form, and the Python module with its code."""
    _settle_coordinate_element(form)
    options = {_jit_options()[0]: {"cffi_extra_compile_args": _compiler_flags()}}
    with _form_cache() as modules:
        return fem.form(form, **options), modules[-1]


def _compiler_flags() -> list[str]:
    """Flags of the compiler for forms."""
    flags = _jit_options()[1]({})["cffi_extra_compile_args"]
    if flags in (["-O2"], ["-O2", "-g0"]):
        flags = _COMPILER_FLAGS
    return [*flags, *form_cache.read_extra_flags()]


def compile_c(comm: Any, declaration: str, source: str) -> Any:
    """C code with the flags and in the cache of forms, see `c_code.compile_c`. Collective."""
    folder = _jit_options()[1]({})["cache_dir"] / "turbine_fenicsx" / "forms"
    return c_code.compile_c(comm, folder, declaration, source, _compiler_flags())


def load_c(comm: Any, path: Path, declaration: str) -> Any | None:
    """Module of a file of C code and `c_code.VECTORS`; None without a compiler. Collective."""
    source = "".join(file.read_text(encoding="utf-8") for file in (c_code.VECTORS, path))
    try:
        return compile_c(comm, declaration, source)
    except CompilationError as error:
        logging.getLogger(__name__).info("%s is not compiled: %s", path.name, error)
        return None


def coefficients_in_order(form: Any, compiled: Any) -> list[Any]:
    """Coefficients of a form in the order of its kernels."""
    code, given = compiled.ufcx_form, form.coefficients()
    name = "original_coefficient_position"
    places = getattr(code, name if hasattr(code, name) else f"{name}s")
    return [given[places[k]] for k in range(code.num_coefficients)]


def has_plain_dofs(space: Any) -> bool:
    """Whether degrees of freedom are the same for cells of all orientations."""
    return not space.element.needs_dof_transformations


def nodes_of_cells(mesh: Any) -> npt.NDArray[np.int32]:
    """Nodes of the geometry of the local cells, shape (cells, nodes per cell)."""
    tables = getattr(mesh.geometry, "dofmaps", None)  # a list from 0.11, where dofmap is deprecated
    table = tables[0] if isinstance(tables, list) else mesh.geometry.dofmap
    return (
        table
        if isinstance(table, np.ndarray)
        else _as_rows(table, mesh.geometry.cmap.create_dof_layout().num_dofs)
    )


def _settle_coordinate_element(form: Any) -> None:
    """Give the mesh of a form the coordinate element that FFCx 0.5 gives it when it compiles.

    Otherwise the signature of a form depends on whether another form was compiled before it in the
    same process, and what one run has compiled is of no use to the next.
    """
    for integral in form.integrals():
        domain = integral.ufl_domain()
        element = domain.ufl_coordinate_element()
        if getattr(getattr(element, "_sub_element", None), "_variant", "settled") is None:
            kind = element.family(), element.cell(), element.degree(), element.quadrature_scheme()
            settled = ufl.FiniteElement(*kind, variant="equispaced")
            domain._ufl_coordinate_element = ufl.VectorElement(settled)


def cells_at(mesh: Any, point: npt.NDArray[np.float64]) -> npt.NDArray[np.int32]:
    """Cells that this rank owns and that hold a point, its surface included.

    Args:
        point: Shape (3,).
    """
    points, dim = point.reshape(1, 3), mesh.topology.dim
    if hasattr(geometry, "bb_tree"):
        near = geometry.compute_collisions_points(geometry.bb_tree(mesh, dim), points)
    else:
        near = geometry.compute_collisions(geometry.BoundingBoxTree(mesh, dim), points)
    found = np.sort(geometry.compute_colliding_cells(mesh, near, points).links(0))
    own: npt.NDArray[np.int32] = found[found < mesh.topology.index_map(dim).size_local]
    return own


def cell_name(mesh: Any) -> str:
    """Name of the cell type, for example "hexahedron"."""
    name = mesh.ufl_cell().cellname
    return str(name() if callable(name) else name)


def facet_measure(mesh: Any, facets: npt.NDArray[np.int32], tags: npt.NDArray[np.int32]) -> Any:
    """Measure of the surface with numbered parts.

    Args:
        facets: Facets of this rank, sorted, shape (n,).
        tags: Number of the part of each, shape (n,).
    """
    mesh_tags = dolfinx.mesh.meshtags(mesh, mesh.topology.dim - 1, facets, tags)
    return ufl.Measure("ds", domain=mesh, subdomain_data=mesh_tags)


def exterior_facets(mesh: Any) -> npt.NDArray[np.int32]:
    """Facets of this rank on the surface of the mesh."""
    tdim = mesh.topology.dim
    mesh.topology.create_connectivity(tdim - 1, tdim)
    found = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    return np.asarray(found, dtype=np.int32)
