"""Meshes as users bring them, right and wrong, for tests of the command line."""

from math import hypot, pi

from turbine_fenicsx.meshing.session import gmsh_session


def write_mesh(path, volumes, surfaces, empty=(), radius=2.25, bricks=1):
    """A user's mesh: boxes of 1 m x 10 m x 1 m on the hub, with physical groups.

    Args:
        path: The file.
        volumes: Names of the boxes; the first three stand where the blades belong, others far off.
        surfaces: For each named surface the number of the box whose inner end it is.
        empty: Names of surfaces that hold no element.
        radius: Where the boxes begin [m].
        bricks: Number of bricks on top of each other that make up a box, not merged.
    """
    with gmsh_session({"Mesh.MeshSizeMin": 1.0, "Mesh.MeshSizeMax": 2.0}) as gmsh:
        model, ends = gmsh.model, []
        for k, name in enumerate(volumes):
            height = 10.0 / bricks
            box = [
                (3, model.occ.addBox(-0.5, radius + i * height, -5.5, 1, height, 1))
                for i in range(bricks)
            ]
            model.occ.rotate(box, 0, 0, 0, 0, 0, 1, 2.0 * pi / 3.0 * (k - 1))
            model.occ.translate(box, 0, 0, 100.0 * (k // 3))
            model.occ.synchronize()
            tags = [tag for _, tag in box]
            model.setPhysicalName(3, model.addPhysicalGroup(3, tags), name)
            faces = [face for _, face in model.getBoundary(box[:1], oriented=False)]
            ends.append(min(faces, key=lambda f: hypot(*model.occ.getCenterOfMass(2, f)[:2])))
        for name, number in surfaces.items():
            end = model.addDiscreteEntity(2) if name in empty else ends[number]
            model.setPhysicalName(2, model.addPhysicalGroup(2, [end]), name)
        model.mesh.generate(3)
        gmsh.write(str(path))


def write_meshes(folder):
    """Meshes of a user by name."""
    blades = ["blade_1", "blade_2", "blade_3"]
    roots = {"root_1": 0, "root_2": 1, "root_3": 2}
    write_mesh(folder / "good.msh", blades, roots)
    write_mesh(folder / "other_names.msh", ["Wing", "Fin", "Tail"], {"Base": 0})
    write_mesh(folder / "two_roots.msh", blades, {"root_1": 0, "root_2": 1})
    write_mesh(folder / "empty_root.msh", blades, roots, empty=["root_2"])
    write_mesh(folder / "more_parts.msh", [*blades, "tower"], roots)
    write_mesh(folder / "root_elsewhere.msh", [*blades, "tower"], roots | {"root_1": 3})
    write_mesh(
        folder / "roots_on_wrong_blades.msh", blades, {"root_1": 1, "root_2": 0, "root_3": 2}
    )
    write_mesh(folder / "off_the_hub.msh", blades, roots, radius=3.0)
    write_mesh(folder / "not_merged.msh", blades, roots, bricks=2)
    write_mesh(folder / "everything.msh", [*blades, "tower"], roots, radius=3.0, bricks=2)
    (folder / "text.msh").write_text("this is no mesh\n")
