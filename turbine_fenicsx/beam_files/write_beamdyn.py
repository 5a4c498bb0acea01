"""Write blades as files of BeamDyn; `turbine_fenicsx.beam_files.beamdyn` has its coordinates."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from turbine_fenicsx.beam_files.beam_blade import BeamBlade
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.types import Array

PRIMARY = """--------- BEAMDYN INPUT FILE ---------------------------------------------------
{title}
---------------------- SIMULATION CONTROL --------------------------------------
False     Echo             - Echo input data to "<RootName>.ech" (flag)
True      QuasiStaticInit  - Use quasi-static pre-conditioning with centripetal accelerations (flag)
0         rhoinf           - Numerical damping parameter for generalized-alpha integrator
2         quadrature       - Quadrature method: 1=Gaussian; 2=Trapezoidal (switch)
DEFAULT   refine           - Refinement factor for trapezoidal quadrature (-)
DEFAULT   n_fact           - Factorization frequency for the Jacobian in N-R iteration (-)
DEFAULT   DTBeam           - Time step size (s)
DEFAULT   load_retries     - Number of factored load retries before quitting the simulation
DEFAULT   NRMax            - Max number of iterations in Newton-Raphson algorithm (-)
DEFAULT   stop_tol         - Tolerance for stopping criterion (-)
DEFAULT   tngt_stf_fd      - Use finite differenced tangent stiffness matrix? (flag)
DEFAULT   tngt_stf_comp    - Compare analytical finite differenced tangent stiffness matrix? (flag)
DEFAULT   tngt_stf_pert    - Perturbation size for finite differencing (-)
DEFAULT   tngt_stf_difftol - Maximum allowable relative difference of tangent stiffness (-)
True      RotStates        - Orient states in the rotating frame during linearization? (flag)
---------------------- GEOMETRY PARAMETER --------------------------------------
1         member_total     - Total number of members (-)
{count:<9} kp_total         - Total number of key points (-) [must be at least 3]
1 {count:<7}                  - Member number; Number of key points in this member
kp_xr               kp_yr               kp_zr               initial_twist
(m)                 (m)                 (m)                 (deg)
{points}
---------------------- MESH PARAMETER ------------------------------------------
10        order_elem       - Order of interpolation (basis) function (-)
---------------------- MATERIAL PARAMETER --------------------------------------
"{blade}" BldFile - Name of file containing properties for blade (quoted string)
---------------------- PITCH ACTUATOR PARAMETERS -------------------------------
False     UsePitchAct      - Whether a pitch actuator should be used (flag)
200       PitchJ           - Pitch actuator inertia (kg-m^2) [used only when UsePitchAct is true]
2E+07     PitchK           - Pitch actuator stiffness (kg-m^2/s^2) [used only when UsePitchAct]
500000    PitchC           - Pitch actuator damping (kg-m^2/s) [used only when UsePitchAct is true]
---------------------- OUTPUTS -------------------------------------------------
False     SumPrint         - Print summary data to "<RootName>.sum" (flag)
"ES10.3E2" OutFmt          - Format used for text tabular output, excluding the time channel
0         NNodeOuts        - Number of nodes to output to file [0 - 9] (-)
1         OutNd            - Nodes whose values will be output (-)
          OutList          - The next line(s) contains a list of output parameters (-)
END of input file (the word "END" must appear in the first 3 columns of the last OutList line)
--------------------------------------------------------------------------------
"""

BLADE = """------- BEAMDYN INDIVIDUAL BLADE INPUT FILE ------------------------------------
{title}
---------------------- BLADE PARAMETERS ----------------------------------------
{count:<9} station_total    - Number of blade input stations (-)
1         damp_type        - Damping type: 0: no damping; 1: stiffness-proportional
---------------------- DAMPING COEFFICIENT -------------------------------------
mu1             mu2             mu3             mu4             mu5             mu6
(s)             (s)             (s)             (s)             (s)             (s)
{mu}
---------------------- DISTRIBUTED PROPERTIES ----------------------------------
{stations}"""


def write_beamdyn(path: Path, blade: BeamBlade, title: str) -> list[Path]:
    """Write a primary file, and the blade file beside it.

    Args:
        path: The primary file, ``NAME.dat``; the other one is ``NAME_blade.dat``.
        title: For the second line of both.

    Returns:
        Both files.
    """
    line, sections = blade.line, blade.sections
    s = np.asarray(sections.stations)
    points, directors = line.at(s)
    twist = np.degrees(np.arctan2(-directors[:, 0, 1], directors[:, 0, 0]))
    rows = np.column_stack([points, twist])
    other = path.with_name(f"{path.stem}_blade{path.suffix}")
    text = PRIMARY.format(title=title, count=len(s), points=_format(rows), blade=other.name)
    parts = [
        f"{place / line.length:.12f}\n{_format(C)}\n\n{_format(M)}\n\n"
        for place, C, M in zip(s, sections.stiffness, sections.inertia, strict=True)
    ]
    mu = _format(np.asarray(sections.viscosity)[None])
    replace_file(path, text.encode())
    text = BLADE.format(title=title, count=len(s), mu=mu, stations="".join(parts))
    replace_file(other, text.encode())
    return [path, other]


def _format(rows: Array) -> str:
    """Rows of numbers."""
    return "\n".join(" ".join(f"{x: .12E}" for x in row) for row in rows)
