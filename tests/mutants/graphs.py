"""Bugs of what scenes place and views show that no test found, with the laws that do now."""

from tests.mutants.mutant import Mutant

CONTENT = "tests/scene/test_content.py"
INSIDES = "tests/scene/test_insides.py"
GROUND = "tests/compiled/test_ground.py"
LAYERS = "tests/view/test_layers.py"
POSE = "tests/view/test_pose.py"

KEPT = "tests/compiled/test_recompile.py"

GRAPHS = (
    Mutant(
        "nodes at the times of another shutter",
        "scene/flatten.py",
        (("before is not None and before.camera.camera.shutter == shutter", "True"),),
        f"{KEPT}::test_nodes_are_placed_anew_where_what_they_name_or_their_times_change",
    ),
    Mutant(
        "borders of fog kept while bodies change",
        "scene/flatten.py",
        (("self.scene.medium is None", "True"),),
        f"{KEPT}::test_nodes_are_placed_anew_where_what_they_name_or_their_times_change",
    ),
    Mutant(
        "nodes of other prototypes",
        "compiled/recompile.py",
        (('names = ("prototypes", "textures",', 'names = ("textures",'),),
        f"{KEPT}::test_nodes_are_placed_anew_where_what_they_name_or_their_times_change",
    ),
    Mutant(
        "a camera that stands in the fog of the scene, whatever it says",
        "scene/flatten.py",
        (
            (
                "scene.medium if camera.camera.medium is None else camera.camera.medium",
                "camera.camera.medium if scene.medium is None else scene.medium",
            ),
        ),
        f"{CONTENT}::test_media_are_those_that_are_said_or_those_around",
    ),
    Mutant(
        "mattes of materials without a name are one",
        "scene/flatten.py",
        (
            (
                "node.bsdf if isinstance(node.bsdf, str) else path",
                "node.bsdf if isinstance(node.bsdf, str) else DEFAULT",
            ),
        ),
        f"{CONTENT}::test_things_stand_in_the_order_of_the_graph_and_are_called_by_their_materials",
    ),
    Mutant(
        "children of a node before what it instances",
        "scene/flatten.py",
        (
            (
                'below.insert(0, (f"{path}/{node.instance}", prototype, *given))',
                'below.append((f"{path}/{node.instance}", prototype, *given))',
            ),
        ),
        f"{CONTENT}::test_things_stand_in_the_order_of_the_graph_and_are_called_by_their_materials",
    ),
    Mutant(
        "a hash of a scene without its lamps",
        "scene/hashing.py",
        (
            (
                "cached[id(shape.shape)] + numbers + light + shape",
                "cached[id(shape.shape)] + numbers + shape",
            ),
        ),
        f"{CONTENT}::test_each_number_has_a_part_in_the_hash",
    ),
    Mutant(
        "a body that may not even hold empty space",
        "scene/bodies.py",
        (("if node.interior not in (None, VACUUM):", "if node.interior is not None:"),),
        f"{INSIDES}::test_nothing_else_is_inside_of_a_body",
    ),
    Mutant(
        "the ground's light measured on the diagonal",
        "compiled/ground.py",
        (("shapes.lowest, shapes.center[2]]", "shapes.lowest, shapes.center[0]]"),),
        f"{GROUND}::test_the_ground_is_below_the_middle_of_all_shapes",
    ),
    Mutant(
        "dark pixels whose error is told over a fifth of the mean",
        "view/layers.py",
        (("DARKEST = 0.1", "DARKEST = 0.2"),),
        f"{LAYERS}::test_the_error_is_told_over_the_value_or_a_tenth_of_the_mean",
    ),
    Mutant(
        "an error of the view that is the mean of those of its channels",
        "view/layers.py",
        (
            (
                "np.sqrt(np.square(error).mean(axis=-1, keepdims=True))",
                "error.mean(axis=-1, keepdims=True)",
            ),
        ),
        f"{LAYERS}::test_the_error_is_told_over_the_value_or_a_tenth_of_the_mean",
    ),
    Mutant(
        "colours in small letters from alpha to red",
        "view/layers.py",
        (('"rgba" if set("rgb") <= set(channels)', '"abgr" if set("rgb") <= set(channels)'),),
        f"{LAYERS}::test_channels_stand_in_the_order_of_colours_and_axes",
    ),
    Mutant(
        "an interval whose ends change places in the view",
        "view/layers.py",
        (
            (
                '"95 % from": bars.low[y, x], "95 % to": bars.high[y, x]',
                '"95 % from": bars.high[y, x], "95 % to": bars.low[y, x]',
            ),
        ),
        f"{LAYERS}::test_a_pixel_of_a_film_lies_between_the_ends_of_its_interval",
    ),
    Mutant(
        "a camera that rolls against the key",
        "view/pose.py",
        (("rotate(tuple(back), -math.degrees(by))", "rotate(tuple(back), math.degrees(by))"),),
        f"{POSE}::test_a_roll_turns_the_camera_with_the_clock_and_the_picture_against_it",
    ),
    Mutant(
        "a camera of the view whose arm turns about its lens",
        "view/pose.py",
        (
            (
                "to_world = placed.motion.at(0.0) @ to_world",
                "to_world = to_world @ placed.motion.at(0.0)",
            ),
        ),
        f"{POSE}::test_a_camera_that_moves_starts_where_it_is_when_its_shutter_opens",
    ),
)
