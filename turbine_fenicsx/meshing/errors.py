"""Exception of the meshing package."""

from turbine_fenicsx.foundation.errors import ModelError


class MeshError(ModelError):
    """A mesh that cannot be made, read or used; the message is one sentence for the user."""
