"""Bugs of scenes that lie far from the origin, and of what is told about them."""

from tests.mutants.mutant import Mutant

SPACE = "tests/scene/test_rendering_space.py"
CONTACTS = "tests/scene/test_warnings_of_contacts.py"
NOISE = "tests/textures/test_noise.py"
STANDS = f"{NOISE}::test_a_pattern_stands_in_the_world_wherever_places_are_measured_from"

RENDERING_SPACE = (
    Mutant(
        "another camera that stays in the world",
        "compiled/recompile.py",
        (("near = shifted(placed, origin)", "near = placed"),),
        f"{SPACE}::test_another_camera_sees_the_same_place",
    ),
    Mutant(
        "motion that is shifted before it turns",
        "compiled/rendering_space.py",
        (("if motion is None or _only_shifts(motion, origin):", "if True:"),),
        f"{SPACE}::test_what_moves_is_shifted_after_its_motion[turns there]",
    ),
    Mutant(
        "keyframes shifted the other way",
        "compiled/rendering_space.py",
        (("f.shift + back[:3, 3]", "f.shift - back[:3, 3]"),),
        f"{SPACE}::test_what_moves_is_shifted_after_its_motion[is there and turns]",
    ),
    Mutant(
        "traces in rendering space",
        "rendering/tracing/trace.py",
        (("(float(c) + o for c, o in", "(float(c) + 0.0 * o for c, o in"),),
        f"{SPACE}::test_traces_are_told_in_the_world",
    ),
    Mutant(
        "media that stay where they are",
        "compiled/rendering_space.py",
        (("medium.moved(-origin)", "medium.moved(0.0 * origin)"),),
        f"{SPACE}::test_pictures_are_those_at_the_origin[cloud-volpath]",
    ),
    Mutant(
        "places of rendering space in the layer of positions",
        "integrators/aov.py",
        (("surface.p + origin_in_world(scene.camera)", "surface.p"),),
        f"{SPACE}::test_pictures_are_those_at_the_origin[motion-path]",
    ),
    Mutant(
        "warnings of the compiler told to nobody",
        "rendering/job.py",
        (("tuple(scene.warnings), self", "tuple(text * 0 for text in scene.warnings), self"),),
        f"{CONTACTS}::test_renders_say_so",
    ),
    Mutant(
        "faces that touch at an edge taken for faces in one place",
        "compiled/warnings/contacts.py",
        (("axis, axis=2).all(axis=2)", "axis, axis=2).any(axis=2)"),),
        f"{CONTACTS}::test_others_are_not[along an edge]",
    ),
    Mutant(
        "noise in rendering space",
        "textures/noise.py",
        (("offset = offset + np.array(spec.scale) * origin", "offset = offset + 0.0 * origin"),),
        STANDS,
    ),
    Mutant(
        "noise whose finer waves stay in rendering space",
        "textures/noise.py",
        (("Cells(cells.x + cells.x,", "Cells(cells.x,"),),
        STANDS,
    ),
    Mutant(
        "textures that know of no rendering space",
        "compiled/scene.py",
        (("packed.tables(origin)", "packed.tables()"),),
        f"{SPACE}::test_a_pattern_in_space_stays_where_it_is",
    ),
)
