"""Claims about sections of hollow blades: published matrices of a blade."""

import numpy as np
import pytest
from windio_files import find_turbine

from turbine_fenicsx import Case
from turbine_fenicsx.foundation.section_matrices import interpolate_matrices
from turbine_fenicsx.materials.laminate_theory import tabulate_walls
from turbine_fenicsx.sections import centres
from turbine_fenicsx.turbine.blades.blade_sections import analyse_row
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.blades.wall_rows import WallRows


def test_sections_of_the_iea_22_have_the_matrices_of_its_file():
    file = str(find_turbine("IEA-22-280-RWT.yaml"))
    case = Case.parse({"turbine": {"file": file}, "blade": {"model": "beam", "damping": 0.0}})
    blades = plan_rotor(case).blades
    walls = WallRows.of(blades.shape, blades.line, 40, 40)
    table = tabulate_walls(walls.plies, walls.cells.thickness, moments=True)
    p = blades.structure
    for part in (0.3, 0.45, 0.6, 0.75, 0.85):
        k = int(np.argmin(np.abs(walls.stations / blades.line.length - part)))
        section = analyse_row(walls, k, table)
        at = walls.stations[[k]]
        S = np.linalg.inv(interpolate_matrices(at, p.stations, p.stiffness)[0])
        M = interpolate_matrices(at, p.stations, p.inertia)[0]
        (low, high), angle = section.bending
        (other_low, other_high), other_angle = centres.find_principal_axes(S)
        assert 1.0 / section.compliance[2, 2] == pytest.approx(1.0 / S[2, 2], rel=0.01)
        assert section.torsion_stiffness == pytest.approx(1.0 / S[5, 5], rel=0.01)
        assert [low, high] == pytest.approx([other_low, other_high], rel=0.02)
        assert np.sin(angle - other_angle) == pytest.approx(0.0, abs=0.005)
        assert section.mass == pytest.approx(M[2, 2], rel=0.01)
        gap = section.shear_centre - centres.find_shear_centre(S)
        assert np.abs(gap).max() < 0.02
        gap = section.tension_centre - centres.find_tension_centre(S)
        assert np.abs(gap).max() < 0.02
