"""Everything that differs between the DOLFINx releases 0.5.2 to 0.11, and nothing else.

Differences are found by looking at what the installed release offers, never by its version number.
All other modules import these names from here.
"""

from __future__ import annotations

import logging
from typing import Any

from petsc4py import PETSc

import dolfinx.fem.petsc
import dolfinx.jit
import dolfinx.mesh
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem

# FFCx 0.5 sets up the root logger at import; its compiler lines are noise to everyone else.
for _handler in logging.getLogger().handlers:
    _handler.setLevel(logging.WARNING)


_COMPILER_FLAGS = [
    "-O3",
    "-g0",
    "-fassociative-math",
    "-fno-math-errno",
    "-fno-signed-zeros",
    "-fno-trapping-math",
]


def vector_space(mesh: Any, degree: int) -> Any:
    """Continuous Lagrange space of vectors of R^3."""
    if hasattr(fem, "functionspace"):
        return fem.functionspace(mesh, ("Lagrange", degree, (3,)))
    return fem.VectorFunctionSpace(mesh, ("Lagrange", degree))


def cellwise_space(mesh: Any, shape: tuple[int, ...] = ()) -> Any:
    """Space of fields that are constant in each cell."""
    if hasattr(fem, "functionspace"):
        return fem.functionspace(mesh, ("DG", 0, shape))
    if shape == ():
        return fem.FunctionSpace(mesh, ("DG", 0))
    return fem.VectorFunctionSpace(mesh, ("DG", 0), dim=shape[0])


def expression(expr: Any, space: Any) -> Any:
    """Compiled expression that can be interpolated into ``space``."""
    points = space.element.interpolation_points
    return fem.Expression(expr, points() if callable(points) else points)


def dofs_of_cells(space: Any) -> npt.NDArray[np.int32]:
    """Block degrees of freedom of the local cells, shape (cells, nodes per cell)."""
    return _as_rows(space.dofmap.list, space.dofmap.dof_layout.num_dofs)


def _as_rows(table: Any, width: int) -> npt.NDArray[np.int32]:
    """An adjacency list or array of one row a cell as an array of shape (cells, width)."""
    if isinstance(table, np.ndarray):
        return table
    return table.array.reshape(-1, width)


def assemble_vector(vector: PETSc.Vec, form: Any) -> None:
    """Assemble a linear form into a ghosted vector, owners' values complete afterwards."""
    with vector.localForm() as local:
        local.set(0.0)
    dolfinx.fem.petsc.assemble_vector(vector, form)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)


def assemble_matrix(matrix: PETSc.Mat, form: Any) -> None:
    """Assemble a bilinear form into a matrix made by `create_matrix`."""
    matrix.zeroEntries()
    dolfinx.fem.petsc.assemble_matrix(matrix, form)
    matrix.assemble()


def create_matrix(form: Any) -> PETSc.Mat:
    """Distributed matrix with the sparsity of a bilinear form."""
    return dolfinx.fem.petsc.create_matrix(form)


def gmsh_model_to_mesh(model: Any, comm: Any, gdim: int = 3) -> tuple[Any, Any, Any]:
    """Distributed mesh, cell tags and facet tags of the gmsh model that rank 0 holds."""
    try:
        from dolfinx.io import gmsh as reader  # from 0.10
    except ImportError:
        from dolfinx.io import gmshio as reader
    # the first three of a named tuple from 0.10
    mesh, cell_tags, facet_tags = tuple(reader.model_to_mesh(model, comm, 0, gdim=gdim))[:3]
    if facet_tags is None:
        none = np.empty(0, dtype=np.int32)
        facet_tags = dolfinx.mesh.meshtags(mesh, mesh.topology.dim - 1, none, none)
    return mesh, cell_tags, facet_tags


def compile_form(form: Any) -> Any:
    """Compiled form.

    Unless the user has set compiler flags (dolfinx_jit_options.json), the compiler may use the laws
    of algebra: a seventh faster, and only round-off changes. No flag ties the code to one
    processor, because caches are shared.
    """
    _settle_coordinate_element(form)
    if hasattr(dolfinx.jit, "get_options"):
        name, options = "jit_options", dolfinx.jit.get_options()
    else:
        name, options = "jit_params", dolfinx.jit.get_parameters()
    if options["cffi_extra_compile_args"] not in (["-O2"], ["-O2", "-g0"]):
        return fem.form(form)
    return fem.form(form, **{name: {"cffi_extra_compile_args": _COMPILER_FLAGS}})


def _settle_coordinate_element(form: Any) -> None:
    """Give the mesh of a form the coordinate element that FFCx 0.5 gives it when it compiles.

    Otherwise the signature of a form depends on whether another form was compiled before it in the
    same process, and what one run has compiled is of no use to the next.
    """
    for integral in form.integrals():
        domain = integral.ufl_domain()
        element = domain.ufl_coordinate_element()
        if getattr(getattr(element, "_sub_element", None), "_variant", "settled") is None:
            domain._ufl_coordinate_element = ufl.VectorElement(
                ufl.FiniteElement(
                    element.family(),
                    element.cell(),
                    element.degree(),
                    element.quadrature_scheme(),
                    variant="equispaced",
                )
            )


def cell_name(mesh: Any) -> str:
    """Name of the cell type, for example "hexahedron"."""
    name = mesh.ufl_cell().cellname
    return str(name() if callable(name) else name)


def facet_measure(mesh: Any, facets: npt.NDArray[np.int32], tags: npt.NDArray[np.int32]) -> Any:
    """Measure of the surface with numbered parts.

    Args:
        mesh: The mesh.
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
