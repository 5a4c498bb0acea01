"""Damaged mesh files, looked at as the command check does it."""

from pathlib import Path

import numpy as np
from damage import damaged

from tests.attack._runs import ROOT
from tests.attack._tally import Tally
from turbine_fenicsx.meshing import BladeGeometry, MeshError, MeshOptions, RotorLayout, build_rotor
from turbine_fenicsx.meshing.read import read_msh
from turbine_fenicsx.turbine.blades.blade_mesh import examine_blades

TRIES = 3000
BLADE = BladeGeometry()
LAYOUT = RotorLayout()
ROOTS = ["root_1", "root_2", "root_3"]


def attack(tries, random, folder):
    """Damage meshes of hexahedra and of tetrahedra, and read them."""
    tally, originals = Tally(), list(_originals(folder))
    for k in range(tries):
        file = folder / f"{k}.msh"
        file.write_bytes(damaged(originals[k % len(originals)], random))
        try:
            tally.hold(look_at(file))
        except Exception as error:
            tally.break_(f"{file}: {type(error).__name__}: {error}")
        else:
            file.unlink()
    return tally


def look_at(file):
    """Say how a file was taken.

    Raises:
        AssertionError: if what was accepted is no mesh.
        Exception: what no user should see.
    """
    try:
        mesh = read_msh(Path(file), LAYOUT.volume_groups, ROOTS)
    except MeshError as error:
        assert "\n" not in str(error).replace(str(file), "")
        return "crash of gmsh, told in a sentence" if "crashes" in str(error) else "refused"
    report, found = mesh.examine(), examine_blades(mesh, LAYOUT, BLADE)
    if report.mistakes or found.mistakes:
        return "read, mistakes named"
    assert np.isfinite(mesh.points).all()
    assert np.isfinite([report.worst_quality, *report.volumes.values()]).all()
    assert report.worst_quality > 0.0
    return "read, still a mesh"


def _originals(folder):
    """Contents of whole mesh files."""
    yield (ROOT / "meshes" / "blade_rotor_2x2x12.msh").read_bytes()
    for cell, degree in (("tetrahedron", 2), ("hexahedron", 2)):
        path = folder / f"{cell}.msh"
        options = MeshOptions(cell=cell, geometry_degree=degree)
        build_rotor(BLADE, LAYOUT, options, path)
        yield path.read_bytes()
