"""The exception of the meshing package."""


class MeshError(ValueError):
    """A mesh that cannot be made, read or used; the message is one sentence for the user."""
