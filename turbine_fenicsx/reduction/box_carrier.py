"""A box along the axis of a beam, which carries it where there is no mesh of its surface."""

from __future__ import annotations

from typing import NamedTuple

from mpi4py import MPI

import numpy as np
import numpy.typing as npt
from dolfinx import mesh

from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.reduction.beam_line import BeamLine


class BoxCarrier(NamedTuple):
    """A box along a beam.

    Attributes:
        carrier: Its mesh.
        start: Facets at the start of the axis, indices local to this rank.
        end: Facets at its end.
    """

    carrier: Carrier
    start: npt.NDArray[np.int32]
    end: npt.NDArray[np.int32]


def box_carrier(
    name: str,
    line: BeamLine,
    widths: tuple[float, float],
    cells: int,
    comm: MPI.Intracomm,
) -> BoxCarrier:
    """A carrier with rectangular sections.

    Args:
        name: Unique name of the body.
        line: Axis and directors of the beam.
        widths: Along the first and the second director [m].
        cells: Number of cells along the axis.
        comm: Communicator of the mesh.

    Note:
        Collective.
    """
    low, high = np.array([-0.5, -0.5, 0.0]), np.array([0.5, 0.5, 1.0])
    box = mesh.create_box(comm, [low, high], [1, 1, cells], mesh.CellType.hexahedron)
    ends = [
        mesh.locate_entities_boundary(box, 2, lambda x, z=z: np.isclose(x[2], z)) for z in (0, 1)
    ]
    X = box.geometry.x
    points, directors = line.at(X[:, 2] * line.length)
    across = X[:, :2] * np.asarray(widths)
    X[:] = points + np.sum(across[:, :, None] * directors, axis=1)
    return BoxCarrier(Carrier(name, box), ends[0], ends[1])
