"""Bugs of random scenes, and of the twin that looks at them."""

from tests.mutants.mutant import Mutant

SCENES = "tests/lab/test_random_scenes.py"

RANDOM_SCENES = (
    Mutant(
        "one scene for all seeds",
        "lab/random_scenes/__init__.py",
        (("Draft(Chance(kind, seed), size)", "Draft(Chance(kind), size)"),),
        f"{SCENES}::test_no_two_scenes_are_alike",
    ),
    Mutant(
        "a kind that Python's hash decides",
        "lab/random_scenes/__init__.py",
        (('Chance("kind", seed)', 'Chance("kind", hash(str(seed)))'),),
        f"{SCENES}::test_a_scene_depends_on_its_seed_and_kind_only",
    ),
    Mutant(
        "the last model of a family never drawn",
        "lab/random_scenes/descriptions.py",
        (("list(Registry(family).values())", "list(Registry(family).values())[:-1]"),),
        f"{SCENES}::test_every_registered_model_is_drawn[filters]",
    ),
    Mutant(
        "examples as they are",
        "lab/random_scenes/descriptions.py",
        (("SHARE = 0.4", "SHARE = 0.0"),),
        f"{SCENES}::test_a_model_that_is_registered_later_is_drawn_too",
    ),
    Mutant(
        "a texture that is brighter than its field allows",
        "lab/random_scenes/descriptions.py",
        ((" and max(found.maximum()) <= interval.high", ""),),
        f"{SCENES}::test_all_are_valid_and_have_light",
    ),
    Mutant(
        "users' shapes taken for as large as the cube",
        "lab/random_scenes/bodies.py",
        (
            (
                "return np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]",
                "return -np.ones(3), np.ones(3)",
            ),
        ),
        "tests/extension/test_users_models.py::test_random_scenes_bring_a_users_shape_into_their_cube",
    ),
    Mutant(
        "rings that are inside out",
        "lab/random_scenes/meshes.py",
        (
            (
                "return _mesh(chance, vertices.reshape(-1, 3), _grid_faces(rows, columns)[:, ::-1]",
                "return _mesh(chance, vertices.reshape(-1, 3), _grid_faces(rows, columns)",
            ),
        ),
        f"{SCENES}::test_closed_bodies_face_outwards",
    ),
    Mutant(
        "bodies before integrators that do not walk",
        "lab/random_scenes/views.py",
        (("(module.EXAMPLES[0].walks_inside or not bodies)", "True"),),
        f"{SCENES}::test_what_scatters_inside_is_in_closed_shapes_and_seen",
    ),
    Mutant(
        "bodies with a far side that is missing",
        "lab/random_scenes/bodies.py",
        ((" if specs_of(Shape)[name].closed]", "]"),),
        f"{SCENES}::test_what_scatters_inside_is_in_closed_shapes_and_seen",
    ),
    Mutant(
        "versions of models without what has a default",
        "core/registration.py",
        (("(*FORMS[family].names, *members_of(family))", "FORMS[family].names"),),
        "tests/extension/test_register.py::test_all_that_others_take_from_a_model_is_in_its_version",
    ),
    Mutant(
        "negative indices counted from the end",
        "simd.py",
        (("index.size and index.min() < 0:", "False:"),),
        "tests/lanewise/test_gather_row.py::test_the_twin_refuses_indices_outside_of_a_table",
        "lanewise",
    ),
)
