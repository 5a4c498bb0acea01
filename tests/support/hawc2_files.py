"""Files of HAWC2: a blade of 20 m as a Timoshenko beam, and with fully populated matrices."""

import numpy as np

C2 = ((0.0, 0.0, 0.0, -10.0), (0.1, -0.2, 10.0, -5.0), (0.2, -0.5, 20.0, 1.0))
"""Sections of c2_def: x, y, z [m], twist [deg]."""

TIMOSHENKO = dict(
    m=200.0,
    x_cg=0.1,
    y_cg=0.02,
    ri_x=0.2,
    ri_y=0.5,
    x_sh=0.25,
    y_sh=0.01,
    E=1.5e10,
    G=5e9,
    I_x=0.01,
    I_y=0.03,
    K=0.015,
    k_x=0.6,
    k_y=0.4,
    A=0.2,
    pitch=3.0,
    x_e=0.15,
    y_e=-0.01,
)
"""Columns after the first one, in their order."""

HTC = """begin new_htc_structure;
  begin main_body; tower
    name        tower ;
    begin timoschenko_input; filename ./data/tower.dat; set 1 1; end timoschenko_input;
  end main_body;
;
  begin main_body;
    name        blade1 ;
    type        timoschenko ;
    {damping} ;
    begin timoschenko_input ;
      filename ./data/blade_st.dat ;
      {fpm}
      set 1 2 ; set subset
    end timoschenko_input;
    begin c2_def;  x y z in blade coordinates
      nsec {count} ;
{sections}
    end c2_def ;
  end main_body;
end new_htc_structure;
"""


def write_hawc2(
    folder,
    rows=None,
    damping="damping_posdef 0.0 0.0 0.0 1e-3 2e-3 3e-3",
    full=False,
    sections=C2,
):
    """Write an htc file and a structural file; the path of the first.

    Args:
        rows: Rows of the table, the first column included; the Timoshenko beam at 0 and 20 m.
        full: Whether they are of fully populated matrices.
    """
    if rows is None:
        rows = [[r, *TIMOSHENKO.values()] for r in (0.0, np.sqrt(10.0**2 + 0.05) * 2.0)]
    (folder / "htc").mkdir(exist_ok=True)
    (folder / "data").mkdir(exist_ok=True)
    table = "\n".join(" ".join(f"{x:.10e}" for x in row) for row in rows)
    text = f"""2 number of sets
#1 a blade
r m x_cg y_cg
$1 1 another subset
{" ".join(["0"] * len(rows[0]))}
$2 {len(rows)}
{table}
#2 another set
"""
    (folder / "data" / "blade_st.dat").write_text(text)
    path = folder / "htc" / "turbine.htc"
    lines = "\n".join(
        f"      sec {k} {x} {y} {z} {twist} ;" for k, (x, y, z, twist) in enumerate(sections, 1)
    )
    path.write_text(
        HTC.format(
            damping=damping,
            fpm="FPM 1 ;" if full else "",
            count=len(sections),
            sections=lines,
        )
    )
    return path
