r"""Bodies without an end: below shapes that are open, as a tube without lids.

Light that walks out of the opening goes on being scattered, for tens of thousands of steps if the
body is white. In three dimensions a random walk is transient: from the distance D of the middle of
a ball of radius R it comes back to the ball with the probability

.. math:: h = R / D ,

the harmonic function that is 1 on the ball and 0 at infinity; so long as R is not less than a mean
free path, which only makes it smaller. With R the radius of a ball around all shapes, h is what a
walk outside may still bring, on average, and Russian roulette plays for that.

Sources: Spitzer 1976, Principles of Random Walk, section 26; Veach 1997, section 10.4, for
roulette by what is still to be expected.
"""

from __future__ import annotations

from alight.bsdfs.interiors.bodies import ENDLESS
from alight.core.vec import Vec3, dot
from lanewise.jit import kernel, specialised
from lanewise.simd import lanes, maximum, minimum, sqrt


@specialised
def chance_of_return(program):
    """``(scene, p) -> h``: of walks at p, metres; 1 where all bodies end."""
    if ENDLESS not in program.bsdfs:
        return _always

    @kernel
    def chance_of_return(scene, p):
        ball = scene.materials.ball
        away = Vec3(p.x - ball[0], p.y - ball[1], p.z - ball[2])
        return minimum(ball[3] / maximum(sqrt(dot(away, away)), 1e-30), 1.0)

    return chance_of_return


@kernel
def _always(scene, p):
    return lanes(1.0)
