"""Claims about damaged files of beams: each is read or refused in a sentence."""

import numpy as np
import pytest
from beamdyn_files import write_beamdyn
from damage import damaged
from elastodyn_files import write_tower
from hawc2_files import write_hawc2

from turbine_fenicsx.beam_files.beamdyn import read_beamdyn
from turbine_fenicsx.beam_files.elastodyn import read_elastodyn_tower
from turbine_fenicsx.beam_files.hawc2 import read_hawc2
from turbine_fenicsx.foundation.errors import FileError, InputError

TRIES = 200
READERS = {
    "beamdyn": (write_beamdyn, read_beamdyn),
    "hawc2": (write_hawc2, read_hawc2),
    "elastodyn": (write_tower, lambda path: read_elastodyn_tower(path, 87.6)),
}


@pytest.mark.parametrize("name", READERS)
def test_damaged_files_are_read_or_refused(tmp_path, name):
    write, read = READERS[name]
    path, random, refused = write(tmp_path), np.random.default_rng(7), 0
    for file in (found for found in tmp_path.rglob("*") if found.is_file()):
        whole = file.read_bytes()
        for _ in range(TRIES):
            file.write_bytes(damaged(whole, random))
            try:
                read(path)
            except (InputError, FileError):
                refused += 1
        file.write_bytes(whole)
    assert refused > TRIES // 4
