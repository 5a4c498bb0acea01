"""How long to wait on a machine that may have other things to do."""

import os


def patience(seconds):
    """So many seconds [s], and in proportion more where programs wait for a core."""
    return seconds * max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))
