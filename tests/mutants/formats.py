"""Bugs of what readers make of people's files."""

from tests.mutants.mutant import Mutant

USD = "tests/formats/usd"
GLTF = "tests/formats/gltf"

FORMATS = (
    Mutant(
        "instances share whatever they inherit",
        "formats/usd/inherited.py",
        (("return _bindings(prim), _primvars(stage, prim)", "return ()"),),
        f"{USD}/test_instances.py::test_a_material_bound_on_an_instance_is_shown",
    ),
    Mutant(
        "pictures of USD's normals without scale and bias",
        "formats/usd/textures.py",
        (("return normals(picture, scale[:3], bias[:3])", "return picture"),),
        f"{USD}/test_normals.py::test_normals_are_scaled_and_shifted_texels",
    ),
    Mutant(
        "skinned meshes left in the space of their skeleton",
        "formats/usd/skins.py",
        (("placed * places.GetLocalToWorldTransform(prim).GetInverse()", "placed"),),
        f"{USD}/test_skins.py::test_meshes_are_where_openusd_itself_bakes_them",
    ),
    Mutant(
        "blend shapes added after the joints have moved",
        "formats/usd/skins.py",
        (
            (
                "self.matrices, points + self.shifts, None)[0]",
                "self.matrices, points, None)[0] + self.shifts",
            ),
        ),
        f"{USD}/test_skins.py::test_meshes_are_where_openusd_itself_bakes_them",
    ),
    Mutant(
        "normalised numbers of Draco streams taken as they are",
        "formats/gltf/draco.py",
        (('said.get("normalized") is True', "False"),),
        f"{GLTF}/test_draco.py::test_all_attributes_come_out_by_their_identifiers",
    ),
    Mutant(
        "Draco streams believed, whatever they announce",
        "formats/gltf/draco.py",
        (("if number > most:", "if False:"),),
        f"{GLTF}/test_draco.py::test_streams_do_not_get_the_memory_that_they_announce",
    ),
    Mutant(
        "instances of a node scaled after they are turned",
        "formats/gltf/instances.py",
        (('tables["SCALE"][:, None, :]', 'tables["SCALE"][:, :, None]'),),
        f"{GLTF}/test_instances.py::test_scale_comes_first_then_rotation_then_translation",
    ),
    Mutant(
        "the camera sees one instance of a node",
        "formats/gltf/instances.py",
        (("for move in moves:", "for move in moves[:1]:"),),
        f"{GLTF}/test_instances.py::test_the_camera_sees_all_instances",
    ),
    Mutant(
        "variants of materials taken by their place in the list of mappings",
        "formats/gltf/variants.py",
        (
            (
                'if number in mapping.indices("variants", len(names), "variants"):',
                'if mapping.pointer.endswith(f"/{number}"):',
            ),
        ),
        f"{GLTF}/test_variants.py::test_a_variant_shows_its_materials",
    ),
    Mutant(
        "triangles of strips all one way round",
        "meshes/strips.py",
        (("    corners[turned, :2] = corners[turned, 1::-1]\n", ""),),
        "tests/meshes/test_mesh_files.py::test_ply_strips_turn_every_other_triangle_around",
    ),
)
