"""What a path knows of the mirrors and the clear glass that it has met."""

from __future__ import annotations

from collections import namedtuple

from alight.bsdfs import dirac
from alight.bsdfs.flags import DELTA_AND_SMOOTH, REFLECTION
from alight.bsdfs.specular import EVENT_BITS
from alight.bsdfs.switch import models_of
from alight.lights.targets import has_targets
from lanewise.jit import kernel
from lanewise.simd import lanes_mask, lanes_u32, lanes_vec3

#: Longest chain that is looked for: a glass ball in another one has four surfaces.
MOST_EVENTS = 6
#: The lowest bit of each event.
EACH = sum(REFLECTION << (EVENT_BITS * i) for i in range(MOST_EVENTS))

#: What a chain does at its surfaces, u32 each; the first event (`alight.bsdfs.specular`) is in the
#: lowest bits. Surfaces that are holes and nothing else, or matte beside them, are no events.
Type = namedtuple("Type", "events count")

#: The chain that a path has followed since it was last scattered. o, d: Vec3, its first ray; type:
#: `Type`; known: mask, there is such a place, and such a type.
Chain = namedtuple("Chain", "o d type known")


def has_chains(program) -> bool:
    """Whether a program has mirrors or clear glass, and lights that paths may aim at."""
    clear = any(m.evaluate is dirac.evaluate and not m.spec.unseen for m in models_of(program))
    return has_targets(program) and (clear or DELTA_AND_SMOOTH in program.bsdfs)


def follows_chains(program) -> bool:
    """Whether caustics are looked for in a program."""
    return program.option("caustics", "paths") == "manifold" and has_chains(program)


@kernel
def no_chain():
    """Before a path is scattered for the first time."""
    black, none = lanes_vec3(0.0), lanes_u32(0)
    return Chain(black, black, Type(none, none), lanes_mask(False))


@kernel
def with_event(type, event):
    """The type with one more event."""
    return Type(type.events | (event << (EVENT_BITS * type.count)), type.count + 1)


@kernel
def turns(type):
    """Mask: something in a chain reflects or transmits the light; holes alone cast no caustics."""
    return ((type.events ^ (type.events >> 1)) & EACH) != 0
