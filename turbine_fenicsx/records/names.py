"""Names in output: columns of ``history.csv`` and ``modes.csv``, keys of ``summary.json``.

Writers and readers both take them from here. A name ends with its unit in brackets.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from string import Formatter

TIME = "time_[s]"
KINETIC_ENERGY = "kinetic_energy_[J]"
STRAIN_ENERGY = "strain_energy_[J]"
POTENTIAL_ENERGY = "potential_energy_[J]"
TOTAL_ENERGY = "total_energy_[J]"
SPRING_ENERGY = "spring_energy_[J]"
EXTERNAL_WORK = "external_work_[J]"
ENERGY_ERROR = "energy_error_[J]"
MAX_STRESS = "max_stress_[Pa]"
CONSTRAINT_ERROR = "constraint_error_[-]"
NEWTON_ITERATIONS = "newton_iterations"
KRYLOV_ITERATIONS = "krylov_iterations"
WALL_TIME = "wall_time_[s]"

SPEED = "speed_[rpm]"
WIND_SPEED = "wind_speed_[m/s]"
PITCH = "pitch_[deg]"
FREE_WIND = "wind_of_free_rotor_[m/s]"
MODE = "mode"
FREQUENCY = "frequency_[Hz]"
DAMPING_RATIO = "damping_ratio_[-]"
GROWTH_RATE = "growth_rate_[1/s]"
RUN_FREQUENCY = "frequency_in_run_[Hz]"
RADIUS = "radius_[m]"
AIR_ALONG = "decay_rate_by_air_per_length_[1/(m*s)]"
MODE_NAME = "name"

END_TIME = "end_time_[s]"
LARGEST_ENERGY = "largest_energy_[J]"
WORST_ENERGY_ERROR = "worst_energy_error_[J]"
ALLOWED_ENERGY_ERROR = "allowed_energy_error_[J]"
WORST_PLY = "worst_ply"
INTERRUPTED = "interrupted"
VERSIONS = "versions"
WARNINGS = "warnings"

SUMMARY = (
    "angles_[rad].{joint}",
    "factors.{what}",
    "halved_steps",
    "masses_[kg].{body}",
    "mean_krylov_iterations",
    "mean_newton_iterations",
    "mesh.{what}",
    "ranks",
    "rotor_inertia_[kgm2]",
    "solver_fallbacks",
    "steps",
    "time_per_step_[s]",
    "time_per_step_by_part_[s].{part}",
    "tower_mesh.{what}",
    "unknowns.{block}",
    "worst_ply.{what}",
    "worst_constraint_error_[-]",
)
"""Other numbers of ``summary.json``, by dotted key."""

_UNIT = re.compile(r"[_ ]\[([^\]]*)\]")


@dataclass(frozen=True)
class Family:
    """Columns whose names differ in what they belong to: a joint, a blade, an axis.

    Args:
        pattern: The name with fields, for example ``"root_force_{blade}_{axis}_[N]"``.
    """

    pattern: str

    def __call__(self, **fields: object) -> str:
        """The column of this family with these fields, for example ``blade=1, axis="x"``."""
        return self.pattern.format(**fields)

    def find(self, columns: Iterable[str], **fields: object) -> dict[str, str]:
        """Columns of this family by the one field that is not given."""
        text = _make_pattern(self.pattern, fields)
        matches = ((column, re.fullmatch(text, column)) for column in columns)
        return {match[1]: column for column, match in matches if match}

    def matches(self, name: str, **fields: object) -> bool:
        """Whether a name is of this family, with or without its unit, with some fields given."""
        patterns = self.pattern, split_unit(self.pattern)[0]
        return any(re.fullmatch(_make_pattern(pattern, fields), name) for pattern in patterns)


DECAY_RATE = Family("decay_rate_{source}_[1/s]")
"""Of a mode: by its eigenvalue, a run, or what takes part in it."""
MEASURED, FITTED = Family("measured_{part}_[-]"), Family("fitted_{part}_[-]")
"""Part of a mode in a run, real or imaginary."""

LINEAR_MOMENTUM = Family("linear_momentum_{axis}_[kgm/s]")
ANGULAR_MOMENTUM = Family("angular_momentum_{axis}_[Nms]")
ANGLE = Family("angle_{joint}_[rad]")
DISPLACEMENT = Family("displacement_{joint}_[m]")
WORK = Family("work_of_{name}_[J]")
DISSIPATION = Family("dissipated_by_{name}_[J]")
PLY_INDEX = Family("{panel}_{criterion}_[-]")
PLY_INDEX_AT = Family("{panel}_{criterion}_at_[m]")
PLY_INDEX_PLY = Family("{panel}_{criterion}_ply_[-]")
PLY_INDEX_BLADE = Family("{panel}_{criterion}_blade_[-]")
PLY_STRAIN = Family("ply_{ply}_blade_{blade}_strain_{component}_[-]")
PLY_STRESS = Family("ply_{ply}_blade_{blade}_stress_{component}_[Pa]")
SECTION_PLY_STRESS = Family("stress_{component}_[Pa]")
SECTION_PLY_INDEX = Family("{criterion}_[-]")
PLY_FAILURE = Family("ply_{ply}_blade_{blade}_{criterion}_[-]")
TIP_DEFLECTION = Family("tip_deflection_{tip}_[m]")
TIP_FLAP = Family("tip_flap_{tip}_[m]")
TIP_EDGE = Family("tip_edge_{tip}_[m]")
TWIST = Family("twist_{blade}_at_{place}_[rad]")
SECTION_FORCE = Family("section_force_{blade}_at_{place}_{axis}_[N]")
SECTION_MOMENT = Family("section_moment_{blade}_at_{place}_{axis}_[Nm]")
SPAN_FORCE = Family("section_force_{axis}_[N]")
SPAN_MOMENT = Family("section_moment_{axis}_[Nm]")
TOWER_SECTION_FORCE = Family("tower_force_at_{place}_{axis}_[N]")
TOWER_SECTION_MOMENT = Family("tower_moment_at_{place}_{axis}_[Nm]")
TIP_CLEARANCE = Family("tip_clearance_{tip}_[m]")
ROOT_FORCE = Family("root_force_{blade}_{axis}_[N]")
ROOT_MOMENT = Family("root_moment_{blade}_{axis}_[Nm]")
TOWER_TOP_DISPLACEMENT = Family("tower_top_displacement_{axis}_[m]")
TOWER_BASE_FORCE = Family("tower_base_force_{axis}_[N]")
TOWER_BASE_MOMENT = Family("tower_base_moment_{axis}_[Nm]")
YAW_BEARING_FORCE = Family("yaw_bearing_force_{axis}_[N]")
YAW_BEARING_MOMENT = Family("yaw_bearing_moment_{axis}_[Nm]")
SHAFT_FORCE = Family("shaft_force_{axis}_[N]")
SHAFT_MOMENT = Family("shaft_moment_{axis}_[Nm]")
POSITION = Family("position_{point}_{axis}_[m]")
VELOCITY = Family("velocity_{point}_{axis}_[m/s]")
AERO_POWER = "aero_power_[W]"
AERO_THRUST = "aero_thrust_[N]"
AERO_TORQUE = "aero_torque_[Nm]"
BLADE_WORK = Family("aero_work_{blade}_[J]")
ROTOR_SPEED = "rotor_speed_[rpm]"
ROTOR_WIND = "rotor_wind_[m/s]"
HUB_WIND = Family("hub_wind_{axis}_[m/s]")
STRAIN = Family("strain_{gauge}_[-]")
JOINT_FORCE = Family("joint_force_{joint}_{axis}_[N]")
JOINT_MOMENT = Family("joint_moment_{joint}_{axis}_[Nm]")

DISTANCE = "distance_[m]"
PLY_ANGLE = "angle_[deg]"
DAMAGE = "damage_[-]"
DAMAGE_BY = Family("damage_by_{measure}_[-]")
FATIGUE_INDEX = "fatigue_index_[-]"
LIFE = "life_[years]"
BOND_RANGE = Family("largest_range_of_{stress}_[Pa]")
SECTION_END = Family("outline_{end}_{axis}_[m]")
SECTION_NORMAL = Family("outline_normal_{axis}_[-]")

MODAL_MASS = Family("modal_mass_of_{part}_[-]")
MOTION_SHARE = Family("share_of_{way}_[-]")


def _make_pattern(pattern: str, fields: Mapping[str, object]) -> str:
    """A regular expression with a group for each field that is not given."""
    parts = [
        (literal, "(.+)" if field not in fields else re.escape(str(fields[field])))
        for literal, field, _, _ in Formatter().parse(pattern)
        if field is not None
    ]
    end = pattern.rpartition("}")[2]
    return "".join(re.escape(literal) + field for literal, field in parts) + re.escape(end)


def split_unit(name: str) -> tuple[str, str]:
    """A name without its unit, and the unit; empty if there is none.

    ``"angles_[rad].yaw"`` becomes ``"angles.yaw"`` and ``"rad"``.
    """
    match = _UNIT.search(name)
    return _UNIT.sub("", name), match[1] if match else ""


def find_column(columns: Iterable[str], name: str) -> str:
    """The column of a name that may lack its unit; the name itself if there is none or more."""
    every = list(columns)
    found = [column for column in every if split_unit(column)[0] == name]
    return found[0] if name not in every and len(found) == 1 else name
