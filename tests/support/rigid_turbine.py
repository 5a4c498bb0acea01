"""The rigid turbine of the paper as a list of parts, without loads."""

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import assemble
from turbine_fenicsx.turbine.components.nacelle import Nacelle
from turbine_fenicsx.turbine.components.pitch import Pitch
from turbine_fenicsx.turbine.components.rigid_blades import RigidBlades


def rigid_turbine(comm, **keys):
    """Five bodies and five joints, in the paper's order.

    Args:
        comm: Communicator.
        keys: Keys of the table ``turbine`` of a case.
    """
    case = Case.parse({"turbine": {"model": "rigid", **keys}})
    return assemble(case, [Nacelle(), RigidBlades(), Pitch()], comm).parts
