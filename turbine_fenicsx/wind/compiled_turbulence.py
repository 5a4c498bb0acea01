"""Turbulence looked up by C code, which does as `TurbulenceField` in a tenth of the time."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.c_code import CompiledCode
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.turbulence import TurbulenceField

DECLARATION = """
typedef struct {
  const float *floats;
  const short *integers;
  int planes, heights, widths, periodic;
  double dt, speed, lead, bottom, rise, left, step;
  const double *slope, *intercept;
} Field;
int find_velocities(const Field *, int, const double *, double, double *);
"""


class _Lookup(CompiledCode):
    """The C code for one field."""

    def __init__(self, module: Any, field: TurbulenceField) -> None:
        super().__init__(module)
        values = np.ascontiguousarray(field.values)
        name, kind = ("integers", "short[]") if values.dtype.kind == "i" else ("floats", "float[]")
        self._kept = [np.array(x, dtype=float) for x in (field.slope, field.intercept)]
        buffer = self._ffi.from_buffer(kind, values)
        slope, intercept = map(self._address, self._kept)
        self._kept += [buffer, slope, intercept]  # C code has their addresses alone
        (left, right), (bottom, top) = field.y[:2].tolist(), field.z[:2].tolist()
        self._field = self._ffi.new("Field *")
        setattr(self._field, name, buffer)
        entries = {
            **dict(zip(("planes", "heights", "widths"), values.shape, strict=False)),
            **{"dt": field.dt, "speed": field.speed, "lead": field.lead},
            **{"bottom": bottom, "rise": top - bottom, "left": left, "step": right - left},
            **{"periodic": field.periodic, "slope": slope, "intercept": intercept},
        }
        for entry, value in entries.items():
            setattr(self._field, entry, value)

    def find(self, places: Array, time: float) -> Array | None:
        """Velocities at places of shape (n, 3); None where the field does not reach one."""
        found = np.empty((len(places), 3))
        addresses = self._address(places), time, self._address(found)
        lacks = self._lib.find_velocities(self._field, len(places), *addresses)
        return None if lacks else found


@dataclass(frozen=True, eq=False)
class CompiledTurbulence(TurbulenceField):
    """A field with the C code for it.

    Attributes:
        module: Of `turbine_fenicsx.foundation.c_code.compile_c`.
    """

    module: Any = None

    @cached_property
    def _lookup(self) -> _Lookup:
        """Made when it is first needed."""
        return _Lookup(self.module, self)

    def velocity(self, position: Array, time: float) -> Array:
        """As of `TurbulenceField`."""
        places = np.asarray(position, dtype=float)
        found = self._lookup.find(places.reshape(-1, 3), time)
        if found is None:  # which raises
            return super().velocity(position, time)
        return found.reshape(places.shape)


def compile_turbulence(field: TurbulenceField) -> TurbulenceField:
    """A field with the C code; the field itself where there is no compiler."""
    module = _compat.load_c(MPI.COMM_SELF, Path(__file__).with_suffix(".c"), DECLARATION)
    if module is None:
        return field
    return CompiledTurbulence(
        **{each.name: getattr(field, each.name) for each in fields(field)}, module=module
    )
