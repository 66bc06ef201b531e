"""Bugs of principled materials, of normal maps, and of what absorbs."""

from tests.mutants.mutant import Mutant

PHYSICS = "tests/physics/test_principled.py"
COATS = "tests/physics/test_coat_normals.py"
BENT = "tests/physics/test_bent_normals.py"
VALUES = "tests/formats/mitsuba/test_values.py"
TINTS = "tests/physics/test_what_passes_is_tinted.py"

PRINCIPLED = (
    Mutant(
        "light between facets of metal given back a tenth too much",
        "bsdfs/disney/view.py",
        (("(1.0 - white) / white, 0.0)", "1.1 * (1.0 - white) / white, 0.0)"),),
        f"{PHYSICS}::test_white_loses_less_than_one_percent_and_gains_nothing[1.0-metal]",
    ),
    Mutant(
        "light between facets of glass not given back",
        "bsdfs/disney/view.py",
        (("1.0 / where(needed, total, lanes_vec3(1.0)), 1.0)", "1.0, 1.0)"),),
        f"{PHYSICS}::test_white_loses_less_than_one_percent_and_gains_nothing[1.0-glass]",
    ),
    Mutant(
        "brushed metal given back from all sides what it loses along the tangent",
        "bsdfs/microfacets/albedo_table.py",
        (("rows_between(rows, _place_of_azimuth(w), ROW)", "rows_between(rows, 1.0, ROW)"),),
        f"{PHYSICS}::test_what_is_brushed_loses_nothing_from_any_side[metal]",
    ),
    Mutant(
        "film over a matte base that looks at three parts of the light in four",
        "bsdfs/disney/view.py",
        (("(i < FILM_PARTS)", "(i < FILM_PARTS - 1)"),),
        f"{PHYSICS}::test_film_gives_back_in_each_color_what_it_does_not_reflect",
    ),
    Mutant(
        "a texture of the coat's strength is not looked up",
        "bsdfs/disney/parameters.py",
        (
            (
                '"transmission", "clearcoat",\n    "clearcoat_roughness"',
                '"transmission",\n    "clearcoat_roughness"',
            ),
        ),
        f"{PHYSICS}::test_each_parameter_alone_may_be_textured[clearcoat]",
    ),
    Mutant(
        "density without that of the coat",
        "bsdfs/disney/lobes.py",
        (("others = coat_pdf + sheen_pdf", "others = sheen_pdf"),),
        f"{PHYSICS}::test_white_loses_less_than_one_percent_and_gains_nothing[0.65-layers]",
    ),
    Mutant(
        "coat of Burley's material counted four times",
        "bsdfs/disney/burley.py",
        (("coat = 0.25 * params.clearcoat", "coat = params.clearcoat"),),
        f"{VALUES}::test_materials_of_files",
    ),
    Mutant(
        "green of normal maps turned over",
        "bsdfs/normals/shading_normals.py",
        (("scale * (2.0 * texel.y - 1.0)", "scale * (1.0 - 2.0 * texel.y)"),),
        f"{BENT}::test_normals_of_a_map_are_its_colours",
    ),
    Mutant(
        "steep normals of matte stuff bent as if it mirrored",
        "bsdfs/normals/shading_normals.py",
        (("where(matte, _seen(n, wo), ", "where(matte, lit_normal(n, wo), "),),
        f"{BENT}::test_a_steep_map_on_matte_stuff_is_as_bright_as_its_normal_is_turned_to_the_light",
    ),
    Mutant(
        "bodies that absorb nothing",
        "compiled/bodies.py",
        (("[body or NO_BODY for body in bodies]", "[NO_BODY for body in bodies]"),),
        "tests/estimators/test_absorption.py::test_light_through_a_body_falls_exponentially",
    ),
    Mutant(
        "thin sheets let everything pass untinted",
        "bsdfs/disney/lobes.py",
        (
            (
                "params.base_color * share_of_glass",
                "where(params.thin, lanes_vec3(1.0), params.base_color) * share_of_glass",
            ),
        ),
        f"{TINTS}::test_what_passes_has_the_tint[sheet-0.8]",
    ),
    Mutant(
        "film of glass seen from inside",
        "bsdfs/disney/view.py",
        (
            (
                "return where(inside, 0.0, params.film.iridescence), found",
                "return params.film.iridescence, found",
            ),
        ),
        f"{TINTS}::test_from_inside_of_glass_nothing_of_its_outer_side_is_seen[film-0.0]",
    ),
    Mutant(
        "coat of glass seen from inside",
        "bsdfs/disney/view.py",
        (
            (
                "return where(inside, 0.0, params.coat.strength), found",
                "return params.coat.strength, found",
            ),
        ),
        f"{TINTS}::test_from_inside_of_glass_nothing_of_its_outer_side_is_seen[coat-0.0]",
    ),
    Mutant(
        "coats that follow the map below them",
        "bsdfs/normals/coat_normals.py",
        (
            (
                "return OwnCoat(apart, where(apart, normal, up), bend,",
                "return OwnCoat(apart, where(apart, bend.n, up), bend,",
            ),
        ),
        f"{COATS}::test_a_smooth_coat_lies_on_a_base_that_a_map_bends[plastic]",
    ),
    Mutant(
        "what is below a tilted coat dimmed at the angle of the base",
        "bsdfs/normals/coat_normals.py",
        (("normal=normal, cosine=dot(normal, wo)", "normal=normal, cosine=wo.z"),),
        f"{COATS}::test_a_tilted_coat_takes_what_it_reflects_at_its_own_angle[plastic]",
    ),
    Mutant(
        "samples that their own lobe does not send out",
        "bsdfs/disney/coat.py",
        (("sent = where(coat, over, below_sends)", "sent = over | below_sends"),),
        f"{COATS}::test_the_laws_of_bsdfs_hold[tilted]",
    ),
    Mutant(
        "pictures of a coat's normals that do not turn",
        "bsdfs/normals/coat_normals.py",
        (
            (
                'packer.numbers("coat_turn", *turn_of(normal))',
                'packer.numbers("coat_turn", *UNTURNED)',
            ),
        ),
        f"{COATS}::test_pictures_of_a_coats_normals_turn_with_their_transforms",
    ),
)
