"""Linear forms that are assembled in every iteration: integrals over cells, several at a time."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import ufl

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation import vectorise
from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.form_cache import describe_processors
from turbine_fenicsx.foundation.parallel import on_rank0

log = logging.getLogger(__name__)

SMALL = 1e-3
"""Displacements with which kernels are tried, in parts of the smallest cell."""

COMPARISON_TOLERANCE = 1e-6
"""Largest difference of forces by round-off, which increments of strain may divide, relative to the
largest force in the same direction."""


class LinearForm:
    """A linear form whose coefficients and constants may change between assemblies. Collective.

    The kernel of FFCx is vectorised over as many cells as a register of the processor has numbers.
    DOLFINx assembles the rest, and all cells if the kernel is not understood. Sums are the same up
    to round-off.
    """

    def __init__(self, form: Any) -> None:
        over_cells = [x for x in form.integrals() if x.integral_type() == "cell"]
        others = [x for x in form.integrals() if x.integral_type() != "cell"]
        self._cells, parts = None, [over_cells, others]
        if len(over_cells) and all(x.subdomain_id() == "everywhere" for x in over_cells):
            try:
                self._cells = CellsInLanes(ufl.Form(over_cells))
                parts = [others]
            except vectorise.NotVectorised as reason:
                log.info("cells are assembled one by one: %s", reason)
        self._forms = [_compat.compile_form(ufl.Form(part)) for part in parts if part]

    @property
    def is_vectorised(self) -> bool:
        """Whether cells are computed several at a time."""
        return self._cells is not None

    def assemble(self, vector: PETSc.Vec) -> None:
        """Assemble into a ghosted vector, owners' values complete afterwards. Collective."""
        with vector.localForm() as local:
            local.set(0.0)
            if self._cells is not None:
                self._cells.add_to(local.array)
        for form in self._forms:
            _compat.add_to_vector(vector, form)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)


class CellsInLanes:
    """An integral over all cells, computed for several cells together. Collective.

    Args:
        form: A UFL form of rank 1 with integrals over all cells.
    """

    def __init__(self, form: Any) -> None:
        compiled, path = _compat.compile_form_with_source(form)
        (space,) = (argument.ufl_function_space() for argument in form.arguments())
        mesh = space.mesh
        source = on_rank0(mesh.comm, lambda: _read(path))
        coefficients = _compat.coefficients_in_order(form, compiled)
        spaces = [f.function_space for f in coefficients]
        if not all(map(_compat.has_plain_dofs, [space, *spaces])):
            raise vectorise.NotVectorised("degrees of freedom depend on the orientation of cells")
        self._n = mesh.topology.index_map(mesh.topology.dim).size_local
        self._tables = [_compat.nodes_of_cells(mesh), *map(_compat.dofs_of_cells, [space, *spaces])]
        self._block = space.dofmap.index_map_bs
        blocks = [3, *(s.dofmap.index_map_bs for s in [space, *spaces])]
        fields = [
            vectorise.Field(table.shape[1], block)
            for table, block in zip(self._tables, blocks, strict=True)
        ]
        code = vectorise.assembly_code(source, fields[0], fields[2:], fields[1])
        self._module = _compile_for_processor(mesh.comm, code)
        self._owners = form.constants()  # views do not keep them alive
        self._constants = [np.ravel(constant.value) for constant in self._owners]
        self._values = [mesh.geometry.x, *(f.x.array for f in coefficients)]
        self._addresses = self._find_addresses()
        self._check(compiled, mesh.comm)

    def _check(self, compiled: Any, comm: MPI.Intracomm) -> None:
        """Compare with DOLFINx once, with values of all coefficients and constants that differ."""
        X = self._values[0][self._tables[0][: self._n]]
        smallest = np.ptp(X, axis=1).max(axis=1).min(initial=np.inf)
        varied = [*self._values[1:], *self._constants]
        before = [np.copy(values) for values in varied]
        for k, values in enumerate(varied):
            waves = np.sin(np.arange(k + 1, k + 1 + values.size, dtype=float)).reshape(values.shape)
            values[...] = (1.0 + SMALL * waves) * values + SMALL * min(smallest, 1.0) * waves
        try:
            expected = _compat.values_of_rank(compiled)
            found = np.zeros(expected.size)
            self.add_to(found)
        finally:
            for values, old in zip(varied, before, strict=True):
                values[...] = old
        finite = np.isfinite(expected)
        rows = [np.where(finite, x, 0.0) for x in (found - expected, expected)]
        # what stands at a node may have different units
        apart, size = (np.abs(x).reshape(-1, self._block).max(axis=0, initial=0.0) for x in rows)
        far = not np.all(apart <= COMPARISON_TOLERANCE * size)
        if comm.allreduce(far, op=MPI.LOR):
            log.warning("vectorised kernels are not those of FFCx, please report it")
            raise vectorise.NotVectorised("results that are not those of DOLFINx")

    def _find_addresses(self) -> Sequence[Any]:
        """Addresses of the arrays that stay where they are."""
        ffi = self._module.ffi
        nodes, rows, *dofs = (ffi.from_buffer("int32_t[]", t) for t in self._tables)
        x, *values = (ffi.from_buffer("double[]", v) for v in self._values)
        return (
            nodes,
            x,
            ffi.new("int32_t *[]", dofs or [ffi.NULL]),
            ffi.new("double *[]", values or [ffi.NULL]),
            rows,
            dofs,
            values,
        )

    def add_to(self, out: Any) -> None:
        """Add the integral to nodal values of this rank, ghosts included, shape (3 nodes,)."""
        nodes, x, dofs, values, rows, *_ = self._addresses
        constants = np.concatenate([*self._constants, np.zeros(1)])
        address = self._module.ffi.from_buffer
        self._module.lib.assemble(
            self._n,
            nodes,
            x,
            dofs,
            values,
            address("double[]", constants),
            rows,
            address("double[]", out),
        )


def _read(path: Path) -> str:
    """C code of a form, if nobody has emptied the cache meanwhile."""
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise vectorise.NotVectorised(f"its code cannot be read: {error}") from None


def _compile_for_processor(comm: MPI.Intracomm, code: str) -> Any:
    """The code for the registers that the processors of all ranks have."""
    widest = comm.allreduce(vectorise.find_registers(describe_processors()), op=MPI.MAX)
    registers = vectorise.REGISTERS[widest]
    target = f'__attribute__((target("{registers.target}")))' if registers.target else ""
    head = f"#define LANES {registers.lanes}\n#define TARGET {target}\n"
    try:
        return _compat.compile_c(comm, vectorise.DECLARATION, head + code)
    except CompilationError as error:
        raise vectorise.NotVectorised(str(error)) from error
