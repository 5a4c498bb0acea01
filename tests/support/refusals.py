"""Mistakes in cases and meshes, and the sentences about them, for tests of the command line."""

from patience import patience

SENTENCE = "error: "


def without_warnings(text):
    """Lines that are not about keys without effect."""
    return [line for line in text.splitlines() if not line.startswith("warning: ")]


def refused(result, seconds):
    """The sentences of a refused command, after checking everything that all refusals share."""
    assert result.returncode == 2, result.stderr
    assert "Traceback" not in result.stderr + result.stdout
    # Without mpirun nothing else is on stderr; mpirun adds its own lines about the exit code.
    sentences = [line for line in result.stderr.splitlines() if line.startswith(SENTENCE)]
    assert sentences
    assert len(set(sentences)) == len(sentences)  # said once, not by every rank
    # before any heavy work: starting python, importing DOLFINx and reading a mesh take 1 to 4 s
    assert seconds < patience(20.0)
    return [sentence.removeprefix(SENTENCE) for sentence in sentences]


# Case, changes, words that the sentence must hold, number of sentences
MISTAKES = {
    "missing file": ("none.toml", [], "cannot read the case file 'none.toml'"),
    "unknown key": ("hybrid_stiff.toml", ["time.stop=1"], "did you mean 'time.step'?"),
    "unknown section": ("rigid.toml", ["tme.end=1"], "unknown key 'tme'; did you mean 'time'?"),
    "negative density": ("hybrid_stiff.toml", ["material.density=-1500"], "material.density"),
    "zero step": ("rigid.toml", ["time.step=0"], "time.step = 0: "),
    "negative step": ("hybrid_soft.toml", ["time.step=-0.02 s"], "time.step = '-0.02 s': "),
    "indefinite material": (
        "hybrid_stiff.toml",
        ["material.poisson=[0.9, 0.9, 0.9]"],
        "not positive definite",
    ),
    "indefinite soft material": (
        "hybrid_soft.toml",
        ["material.shear_modulus=-1 GPa"],
        "not positive definite",
    ),
    "chord of wrong length": ("hybrid_stiff.toml", ["blade.chord=[1, 2]"], "blade.chord"),
    "bad override": ("rigid.toml", ["time.end"], "write --set section.key=value"),
    "wrong unit": ("rigid.toml", ["loads.rotor_torque=3 kN"], "expected a torque, for example"),
    "missing mesh": ("hybrid_stiff.toml", ["mesh.file=none.msh"], "none.msh"),
    "missing groups": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/other_names.msh"],
        "'blade_1', 'blade_2', 'blade_3' .*it has the volumes 'Fin', 'Tail', 'Wing' and the "
        "surface 'Base'",
    ),
    "missing root": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/two_roots.msh"],
        "lacks the physical surface 'root_3'; it has .* 'root_1', 'root_2'",
    ),
    "hub without nodes": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/empty_root.msh"],
        "lacks the physical surface 'root_2'",
    ),
    "root on another part": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/root_elsewhere.msh"],
        "belong to none of the groups blade_1, blade_2, blade_3",
        2,
    ),
    "more than the blades": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/more_parts.msh"],
        "belong to none of the groups blade_1, blade_2, blade_3",
    ),
    "roots on the wrong blades": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/roots_on_wrong_blades.msh"],
        "faces of the group root_1 do not lie on blade_1",
        2,
    ),
    "blades off the hub": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/off_the_hub.msh"],
        "root_1 does not touch the hub: .* up to 0.75 m from the hub surface",
        3,
    ),
    "bricks that are not merged": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/not_merged.msh"],
        "blade_1 falls into 2 parts without a common face, .* nodes of the mesh lie on top of",
        3,
    ),
    "modulus that is no number": (
        "hybrid_stiff.toml",
        ["material.young=[nan, 15e9, 15e9]"],
        "material.young",
    ),
    "mesh that is none": (
        "hybrid_stiff.toml",
        ["mesh.file={meshes}/text.msh"],
        "is not a mesh in gmsh's .msh format",
    ),
}


def arguments_of(name, changes, demo, meshes):
    """Arguments of the command line for a mistake, without the output folder."""
    changes = [change.format(meshes=meshes) for change in changes]
    case = demo(name) if demo(name).exists() else name
    return [str(case), *(["--set", *changes] if changes else [])]
