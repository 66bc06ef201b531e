r"""Weights of bidirectional path tracing, from two numbers that each end of a path carries along.

A path :math:`x_0 \dots x_k` from a light to the camera may be found by many techniques: that of
number s joins s vertices of a light path with the others of a camera path, and has the density
:math:`p_s`, the product of the densities (per square metre) of its vertices, each from its own
side. With :math:`\overrightarrow p_i` and :math:`\overleftarrow p_i` for :math:`x_i` drawn from the
light's and from the camera's side,

.. math::
    w_s = \frac{p_s^\alpha}{\sum_j p_j^\alpha} =
    \frac{1}{1 + W_{<s}^\alpha + W_{>s}^\alpha}, \qquad
    W_{<s}^\alpha = \sum_{j<s} \prod_{i=j}^{s-1}
    \Bigl( \frac{\overleftarrow p_i}{\overrightarrow p_i} \Bigr)^\alpha

and likewise :math:`W_{>s}`. The sum of quotients at a vertex follows from that at the vertex
before: of the technique that joins the last edge (`near`), and of all before it (`far`), where the
density of the way back is still missing,

.. math::
    W = \overleftarrow p_{s-1}\; \Bigl( \mathrm{near} \oplus q\, \mathrm{far} \Bigr), \qquad
    a \oplus b = (a^\alpha + b^\alpha)^{1/\alpha}

with the density q per steradian of the direction back to the vertex before. On the way from a
vertex to the next one, with the density p of its direction, cosines c and c' at both ends and
the distance d,

.. math::
    \mathrm{near}' = \frac{d^2}{p\, c'}, \qquad
    \mathrm{far}' = \frac{c}{p\, c'} \bigl(\mathrm{near} \oplus q\, \mathrm{far}\bigr).

A vertex with a delta lobe can be joined to nothing: its near' is 0, and p and q cancel. Roots
instead of powers keep float32 from overflowing, but for edges that run along a surface without
bounds: all quotients end at `LARGEST`, since infinity times a density of 0 would be no number.

Source: Veach 1997, Robust Monte Carlo methods for light transport simulation, chapter 10; Georgiev,
Implementing vertex connection and merging, 2012 (dVCM and dVC are `near` and `far`); van
Antwerpen, Recursive MIS computation for streaming BDPT on the GPU, 2011.
"""

from __future__ import annotations

from collections import namedtuple

from lanewise.jit import kernel, specialised
from lanewise.simd import minimum, sqrt, where

#: Of edges a million kilometres long; its square is a float32.
LARGEST = 1e18

#: What one end of a path carries along; see above.
Techniques = namedtuple("Techniques", "near far")


@kernel
def _sum(a, b):
    return a + b


@kernel
def _norm(a, b):
    return sqrt(a * a + b * b)


@kernel
def _share(total):
    return 1.0 / (1.0 + total)


@kernel
def _squared_share(total):
    return 1.0 / (1.0 + total * total)


@specialised
def together(program):
    """``together(a, b)``: quotients of two sets of techniques as that of both."""
    return _sum if program.option("heuristic") == "balance" else _norm


@specialised
def weight_beside(program):
    """``weight_beside(total)``: of the technique at hand beside all others."""
    return _share if program.option("heuristic") == "balance" else _squared_share


@kernel
def techniques_at(techniques, distance, per_cos):
    """At the end of a ray, which meets a surface; per_cos: one over its cosine."""
    near = techniques.near * (distance * distance * per_cos)
    return Techniques(minimum(near, LARGEST), minimum(techniques.far * per_cos, LARGEST))


@kernel
def techniques_beyond(techniques, cosine, pdf, reverse, delta):
    """Of the next ray, which leaves at that cosine.

    Parameters
    ----------
    techniques : Techniques
        At the vertex.
    cosine : float
    pdf, reverse : float
        Density of the ray's direction, and of the way back, per steradian; positive.
    delta : mask
        It was chosen by a delta lobe.
    """
    per_pdf = 1.0 / pdf
    far = minimum((cosine * per_pdf) * all_behind(techniques, reverse), LARGEST)
    return Techniques(where(delta, 0.0, per_pdf), where(delta, cosine * techniques.far, far))


@kernel
def all_behind(techniques, reverse):
    """Quotient of all techniques behind a vertex, but for its own density from the other side."""
    return minimum(together(techniques.near, reverse * techniques.far), LARGEST)
