"""The memory of a guide, as kernels see it.

A guide is a binary tree over space with a quadtree over directions in each of its leaves (Müller,
Gross and Novák, Practical path guiding, EGSR 2017).

*Space* is a list of words, the root first: either the number of the first of two children, the
second being the next word, or `LEAF` | number of a leaf. Nodes are halved along x, y and z in turn.

*Directions* are points of the unit square (`alight.core.equal_area`). A node of a quadtree divides
its square into four quadrants, numbered along x first. It has two words: the probabilities of the
lower half, and of the left quadrant within the lower and within the upper half, each in units of
1 / `PARTS`; and the number of the first node that divides one of its quadrants further, shifted by
four bits, with a bit for each quadrant that is so divided. Their nodes follow one another.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from lanewise.view import View

#: box: float32, lower corner of the space and 1 / its extent, x, y and z each; space: u32;
#: roots: u32, node of each leaf's square; leaves: float32, `LEAF_ROW` numbers each; nodes: u32,
#: `NODE` words each; picture: float32, luminance of blocks of pixels; blocks: u32, blocks in a row
#: of the picture, and float32 bits of blocks a pixel, across and down.
Guide = namedtuple("Guide", "box space roots leaves nodes picture blocks")

#: Of a leaf: the probability with which the guide chooses the direction, not the BSDF; the root
#: mean square of the luminance that a vertex gains from the direction; from `FOCUS` on the middle
#: and the radius of the sphere on which light lies, in metres (`alight.guiding.parallax`).
LEAF_ROW, FOCUS = 6, 2

#: What of a guide does not belong to its tree: `box`, `picture` and `blocks` as arrays.
Frame = namedtuple("Frame", "box picture blocks")

#: Option of programs whose kernels are given a guide.
GUIDED = "guided"

LEAF = 0x80000000
NODE = 2
PART_BITS, PARTS = 10, 1 << 10
QUADRANTS = 4

#: What training paths leave behind. rows: `RECORD` float32 a vertex; count: vertices, and how many
#: did not fit; ends, without: float32, luminance of each finished sample, and its part of the
#: second moment without the guide; window: u32, first column and row of the tile, its columns,
#: first sample, samples a pixel, replicates.
Log = namedtuple("Log", "rows count ends without window")

#: What light paths of training leave behind: `LIGHT_RECORD` float32 a vertex, and counts as above.
LightLog = namedtuple("LightLog", "rows count")

#: A vertex: position, direction that the light comes from, luminance of its flux, and 1 / length of
#: its way since it was last scattered (per metre).
LIGHT_RECORD = 8

#: A vertex: position, direction, density of the direction, that of the BSDF alone; luminance of
#: f cos over the density, of the throughput after the vertex, and of the radiance gathered before;
#: number of the sample (bits).
RECORD = 12


def no_log() -> Log:
    """Room for nothing."""
    return Log(
        rows=View(np.zeros(0, np.float32)),
        count=View(np.zeros(2, np.int64)),
        ends=View(np.zeros(0, np.float32)),
        without=View(np.zeros(0, np.float32)),
        window=View(np.zeros(6, np.uint32)),
    )
