"""A small turbine of a windIO file without a layup, with beam blades, in wind."""

from reduced_turbines import CASE, COMM, CONTROL
from windio_files import small_turbine, write_turbine
from windio_polars import add_polars

from turbine_fenicsx.foundation.parallel import on_rank0

STIFFNESS = {"K11": 2e8, "K22": 3e8, "K33": 2e9, "K44": 3e8, "K55": 1.2e8, "K66": 6e7, "K45": 2e7}
"""Of the root [N, N m^2]; a tenth of it at the tip."""

INERTIA = {"mass": 200.0, "cm_x": 0.01, "cm_y": -0.05, "i_edge": 30.0, "i_flap": 12.0, "i_cp": 1.0}
"""Of the root [kg/m, m, kg m]; mass and inertia are a tenth at the tip."""


CONTROLLED = (
    "control.kind=pi",
    "drivetrain.ratio=1",
    "pitch.drive=actuator",
    "pitch.initial=0.35",
    "control.torque.cut_in_speed=0.2",
    "control.torque.optimal_speed=0.4",
    "control.torque.gain=5e3",
    "control.torque.rated_speed=0.95",
    "control.torque.rated_power=1e4",
    "control.torque.largest=1.2e4",
    "control.pitch.speed=1.0",
    "control.pitch.proportional_gain=5.0",
    "control.pitch.integral_gain=0.5",
    "control.pitch.gain_angle=0.3",
    "control.pitch.fine=0.35",
)
"""A controller that suits the plates which are the blades: they turn slowly at much pitch."""


def section_matrices(mu=0.002):
    """Matrices of a blade of 20 m.

    Args:
        mu: Damping of all strains [s].
    """
    stiffness = {f"K{i}{j}": [0.0, 0.0] for i in range(1, 7) for j in range(i, 7)}
    stiffness |= {key: [value, 0.1 * value] for key, value in STIFFNESS.items()}
    inertia = {key: [value, 0.1 * value] for key, value in INERTIA.items()}
    inertia |= {key: [INERTIA[key], INERTIA[key]] for key in ("cm_x", "cm_y")}
    inertia["i_plr"] = [a + b for a, b in zip(inertia["i_edge"], inertia["i_flap"], strict=True)]
    grid = [0.0, 1.0]
    return {
        "stiffness_matrix": {"grid": grid, **stiffness},
        "inertia_matrix": {"grid": grid, **inertia},
        "structural_damping": {"mu": [mu] * 6},
    }


def bare_turbine(mu=0.002):
    """Tables of the small turbine, whose blades have section matrices in place of a layup."""
    tables = add_polars(small_turbine()) | {"control": CONTROL}
    tables["components"]["blade"]["structure"] = {"elastic_properties": section_matrices(mu)}
    steel = [material for material in tables["materials"] if material["name"] == "steel"]
    return tables | {"materials": steel}


def write_beam_case(folder, change=lambda tables: None):
    """Write a case and its turbine into a folder; the path of the case. Collective.

    Args:
        change: Changes the tables of the turbine.
    """

    def write():
        tables = bare_turbine()
        change(tables)
        write_turbine(tables, folder)
        text = CASE.replace('tip = "open"\n', "").replace('"reduced"', '"beam"')
        text = text.replace(
            "[output]\n", "[output]\nsections = [0.0, 0.4]\ntower_sections = [0.0]\n"
        )
        first, last = text.index("[blade.reduction]"), text.index("[tower]")
        path = folder / "case.toml"
        path.write_text(text[:first] + text[last:])
        return path

    return on_rank0(COMM, write)
