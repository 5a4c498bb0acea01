"""Bodies that deform, however they are discretised."""

from __future__ import annotations

from typing import TypeAlias

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBody

DeformableBody: TypeAlias = FlexibleBody | ReducedBody
"""A body that deforms."""
