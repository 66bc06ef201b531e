"""Which light is sampled: by power from one table, or for each point by a light tree."""

from __future__ import annotations

from alight.core.distributions import sample_discrete
from alight.lights.tables import INFO, STRIDE
from alight.lights.tree.traversal import Choice, choose_by_tree, mis_probability
from lanewise.jit import kernel, specialised
from lanewise.simd import as_int, as_uint, gather, horizontal_max, lanes, to_float, where


@specialised
def choose_light(program):
    """``choose_light(scene, p, n, u, u2, active) -> Choice``: a light for the point p.

    n: the normal on the side that is lit, see `lit_normal`; u: chooses; u2: the numbers that will
    choose the direction, of which the tree uses the digits that u lacks.
    """
    if program.light_tree:
        return choose_by_tree
    if program.single_light:

        @kernel
        def the_only_one(scene, p, n, u, u2, active):
            # A uniform index: its rows are loaded once for all lanes.
            return Choice(0, lanes(1.0), lanes(1.0), u)

        return the_only_one

    @kernel
    def by_power(scene, p, n, u, u2, active):
        count = scene.lights.info.size // INFO
        index, probability, rest = sample_discrete(scene.lights.cdf, 0, count, u)
        return Choice(index, probability, probability, rest)

    return by_power


@specialised
def chosen_probability(program):
    """``chosen_probability(scene, index, prim, p, active)``: `Choice.mis_pmf` of a light.

    index, prim: row of the light, and triangle of its mesh; p: the point that it was sampled for.
    """
    if program.light_tree:
        return mis_probability

    @kernel
    def of_its_row(scene, index, prim, p, active):
        return gather(scene.lights.data, index * STRIDE + 3)

    return of_its_row


@specialised
def light_index(program):
    """``light_index(light)``: row of the light with the number light = index + 1; 0 for none."""
    if program.single_light:

        @kernel
        def the_only_one(light):
            return 0

        return the_only_one

    @kernel
    def one_less(light):
        return where(light > 0, light - 1, 0)

    return one_less


@specialised
def lit_normal(program):
    """``lit_normal(ns, wo)``: the normal on the viewer's side, for `sample_light`; wo is local."""
    if not program.light_tree:

        @kernel
        def any_side(ns, wo):
            return ns

        return any_side

    @kernel
    def of_the_viewer(ns, wo):
        return where(wo.z < 0.0, -ns, ns)

    return of_the_viewer


@kernel
def of_one_kind(mine, index):
    """Rows of lights that are all of one kind, that of the rows in the lanes of `mine`.

    Rows of other kinds say other things (where a map begins, not which shape shines), and would
    lead out of the tables: those lanes ask about one of these lights too.
    """
    some = as_uint(as_int(horizontal_max(where(mine, to_float(index), 0.0))))
    return where(mine, index, some)
