"""Bodies that deform, however they are discretised."""

from __future__ import annotations

from typing import TypeAlias

from turbine_fenicsx.bodies.flexible_body import FlexibleBody

DeformableBody: TypeAlias = FlexibleBody
"""A body that deforms."""
