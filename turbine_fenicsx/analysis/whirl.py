"""How the rotor goes round in a mode, seen from what carries it.

The whirling part of a motion z = a + i b is -J^2 z. There J is i for patterns that go round about
the axis and -i for those against it. Their parts of the modal mass are

    1/2 |J z|^2 +- a . M J b,    |J z|^2 = J a . M J a + J b . M J b,

and that of the collective pattern is z* . M P z with P = 1/N sum_j C^j.
"""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.cyclic_shift import CyclicShift
from turbine_fenicsx.analysis.linear_system import LinearSystem, zero_matrix
from turbine_fenicsx.analysis.mode import Whirl
from turbine_fenicsx.foundation.types import Array


class WhirlMeter:
    """Measures how motions whirl.

    Args:
        speed: Speed of the rotation, which says what is forward [rad/s].
    """

    def __init__(self, linear: LinearSystem, shift: CyclicShift, speed: float) -> None:
        self._mass, self._blades, self._sense = linear.mass, shift.blades, np.sign(speed)
        self._zeros = [
            zero_matrix(m) if C is None else None
            for m, C in zip(linear.system.flexible_models, shift.bodies, strict=True)
        ]
        self._C = self._on_vectors(linear, shift.bodies, shift.rigid)
        self._J = self._on_vectors(linear, shift.body_generators, shift.rigid_generator)

    def measure(self, a: PETSc.Vec, b: PETSc.Vec) -> Whirl | None:
        """Shares of the modal mass of the rotor in the motion a + i b.

        None if the rotor is at rest, or takes no part.
        """
        image, Ja, Jb = (a.duplicate() for _ in range(3))
        turned = [x.copy() for x in (a, b)]
        whirling = 0.0
        for x, y in ((a, Ja), (b, Jb)):
            self._J.mult(x, y)
            self._mass.mult(y, image)
            whirling += image.dot(y)
        difference = 2.0 * self._sense * image.dot(a)  # image is M J b
        rotor = collective = 0.0
        for _ in range(self._blades):
            rotor = 0.0
            for x, y in zip((a, b), turned, strict=True):
                self._C.mult(y, image)
                image.copy(y)
                self._mass.mult(y, image)
                rotor += image.dot(x)
            collective += rotor / self._blades
        for vector in (image, Ja, Jb, *turned):
            vector.destroy()
        if not self._sense or rotor <= 0.0:
            return None
        parts = [0.5 * (whirling + difference), 0.5 * (whirling - difference), collective]
        forward, backward, alike = (max(part / rotor, 0.0) for part in parts)
        others = max(1.0 - forward - backward - alike, 0.0)
        return Whirl(forward, backward, alike, others)

    def destroy(self) -> None:
        """Free what is not part of the cyclic shift. Collective."""
        for matrix in (*self._zeros, self._C, self._J):
            if matrix is not None:
                matrix.destroy()

    def _on_vectors(
        self, linear: LinearSystem, bodies: tuple[PETSc.Mat | None, ...], rigid: Array
    ) -> PETSc.Mat:
        """The matrix of flat vectors; joint coordinates have no mass, and are left out."""
        values = np.zeros((linear.vectors.n_y,) * 2)
        values[: len(rigid), : len(rigid)] = rigid
        blocks = [
            zero if matrix is None else matrix
            for matrix, zero in zip(bodies, self._zeros, strict=True)
        ]
        return linear.vectors.block_diagonal(blocks, values)
