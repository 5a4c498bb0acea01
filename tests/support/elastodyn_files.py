"""A tower file of ElastoDyn."""

TOWER = """------- ELASTODYN V1.00.* TOWER INPUT FILE -------------------------------------
a tower
---------------------- TOWER PARAMETERS ----------------------------------------
          3   NTwInpSt    - Number of input stations to specify tower geometry
          1   TwrFADmp(1) - Tower 1st fore-aft mode structural damping ratio (%)
---------------------- TOWER ADJUSTMUNT FACTORS --------------------------------
          1   FAStTunr(1) - Tower fore-aft modal stiffness tuner, 1st mode (-)
        1.1   AdjTwMa     - Factor to adjust tower mass density (-)
          2   AdjFASt     - Factor to adjust tower fore-aft stiffness (-)
          1   AdjSSSt     - Factor to adjust tower side-to-side stiffness (-)
---------------------- DISTRIBUTED TOWER PROPERTIES ----------------------------
  HtFract       TMassDen         TwFAStif       TwSSStif
   (-)           (kg/m)           (Nm^2)         (Nm^2)
0.0000000E+00  5.5908700E+03  6.1434300E+11  6.0000000E+11
5.0000000E-01  4.5000000E+03  3.5000000E+11  3.4000000E+11
1.0000000E+00  3.4000000E+03  1.8000000E+11  1.7000000E+11
---------------------- TOWER FORE-AFT MODE SHAPES ------------------------------
     0.7004   TwFAM1Sh(2) - Mode 1, coefficient of x^2 term
"""


def write_tower(folder, text=TOWER):
    """Write it; its path."""
    path = folder / "tower.dat"
    path.write_text(text)
    return path
