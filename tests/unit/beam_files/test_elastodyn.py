"""Claims about tower files of ElastoDyn: stiffness by direction, factors, what is refused."""

import numpy as np
import pytest
from elastodyn_files import TOWER, write_tower

from turbine_fenicsx.beam_files.elastodyn import read_elastodyn_tower
from turbine_fenicsx.foundation.errors import InputError


def test_bending_fore_and_aft_is_about_the_axis_to_the_side(tmp_path):
    found = read_elastodyn_tower(write_tower(tmp_path), 87.6)
    assert found.stations == pytest.approx([0.0, 43.8, 87.6])
    diagonal = np.einsum("mii->mi", found.stiffness)
    assert diagonal[:, 4] == pytest.approx(2.0 * np.array([6.14343e11, 3.5e11, 1.8e11]))
    assert diagonal[:, 3] == pytest.approx([6e11, 3.4e11, 1.7e11])
    assert found.inertia[:, 2, 2] == pytest.approx(1.1 * np.array([5590.87, 4500.0, 3400.0]))
    # stretch is that of steel of this mass
    assert diagonal[:, 2] == pytest.approx(found.inertia[:, 2, 2] * 210e9 / 7850.0)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("NTwInpSt", "Number", "is no file of ElastoDyn (tower): it has no NTwInpSt"),
        ("HtFract", "Height", "it has no HtFract"),
        ("5.0000000E-01", "1.5", "HtFract must rise from 0 to 1"),
        ("4.5000000E+03", "x", "line 15: a row of its table is wrong: expected 4 numbers"),
        ("1.7000000E+11", "-1.0", "must be positive, they are not at HtFract = 1"),
        ("4.5000000E+03", "0.0", "must be positive, they are not at HtFract = 0.5"),
    ],
)
def test_wrong_files_are_refused(tmp_path, old, new, sentence):
    with pytest.raises(InputError) as caught:
        read_elastodyn_tower(write_tower(tmp_path, TOWER.replace(old, new, 1)), 87.6)
    assert sentence in str(caught.value)
