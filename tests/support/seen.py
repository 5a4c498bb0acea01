"""An observer for tests: what a function says of each snapshot."""

import numpy as np


class Seen:
    """Keeps what a function says of the start and of each step, in ``values``."""

    name = "seen"

    def __init__(self, function):
        self.function, self.values = function, []

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, snapshot):
        self.values.append(self.function(snapshot))

    def finish(self):
        pass

    @property
    def columns(self):
        """An array for each thing that the function says."""
        return [np.array(column) for column in zip(*self.values, strict=True)]
