"""Files of BeamDyn: the twisted bar of its test bd_static_twisted_with_k1, and others like it."""

import numpy as np

STIFFNESS = np.diag([8.2604167e9, 8.2604167e9, 2.5e10, 0.520833e9, 0.130208333e9, 0.141872656e9])
INERTIA = np.diag([678.935, 678.935, 678.935, 973.04, 972.86, 1945.9])
KEY_POINTS = ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 5.0, 45.0), (0.0, 0.0, 10.0, 90.0))

PRIMARY = """--------- BEAMDYN with OpenFAST INPUT FILE -------------------------------------------
a bar
---------------------- SIMULATION CONTROL --------------------------------------
False         Echo            - Echo input data to "<RootName>.ech" (flag)
2             quadrature      - Quadrature method: 1=Gaussian; 2=Trapezoidal (switch)
---------------------- GEOMETRY PARAMETER --------------------------------------
          1   member_total    - Total number of members (-)
{count:11d}   kp_total        - Total number of key points (-) [must be at least 3]
     1 {count:6d}             - Member number; Number of key points in this member
kp_xr \t\t\t kp_yr \t\t\t kp_zr \t\tinitial_twist
(m)  \t\t\t (m)  \t\t\t (m)    \t(deg)
{points}
---------------------- MESH PARAMETER ------------------------------------------
          5   order_elem     - Order of interpolation (basis) function (-)
---------------------- MATERIAL PARAMETER --------------------------------------
"bar_blade.dat"    BldFile - Name of file containing properties for blade (quoted string)
---------------------- PITCH ACTUATOR PARAMETERS -------------------------------
{actuator}        UsePitchAct - Whether a pitch actuator should be used (flag)
"""

BLADE = """ ------- BEAMDYN V1.00.* INDIVIDUAL BLADE INPUT FILE --------------------------
 a bar
 ---------------------- BLADE PARAMETERS --------------------------------------
{count}   station_total    - Number of blade input stations (-)
{kind}   damp_type        - Damping type (switch): 0: none; 1: stiffness-proportional; 2: modal
------ Stiffness-Proportional Damping [used only if damp_type=1] ---------------
   mu1        mu2        mu3        mu4        mu5        mu6
   (-)        (-)        (-)        (-)        (-)        (-)
1.0E-03    1.1D-03    1.2E-03     0.0014      0.0022     0.0022
------ Distributed Properties --------------------------------------------------
{stations}
"""


def write_beamdyn(
    folder,
    points=KEY_POINTS,
    matrices=((0.0, STIFFNESS, INERTIA), (1.0, STIFFNESS, INERTIA)),
    kind=1,
    actuator="False",
):
    """Write both files; the path of the primary one.

    Args:
        points: Key points with their twist [m, deg].
        matrices: Place, stiffness and mass of each station.
        kind: damp_type.
    """
    rows = "\n".join(" ".join(f"{x:.7E}" for x in row) for row in points)
    text = PRIMARY.format(count=len(points), points=rows, actuator=actuator)
    stations = "\n".join(f"  {place:f}\n{_format(C)}\n\n{_format(M)}\n" for place, C, M in matrices)
    (folder / "bar_blade.dat").write_text(
        BLADE.format(count=len(matrices), kind=kind, stations=stations)
    )
    path = folder / "bar.dat"
    path.write_text(text)
    return path


def _format(matrix):
    """Six rows of six numbers."""
    return "\n".join("   ".join(f"{x:.9E}" for x in row) for row in matrix)
