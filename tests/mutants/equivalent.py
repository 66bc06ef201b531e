"""Slips of the campaign that change nothing that is promised, each with its reason."""

#: Name of the mutant, as the campaign prints it: why no test could find it.
EQUIVALENT: dict[str, str] = {
    "core/maths.py arctan2: 1.0 -> 1.02": (
        "divides 0 by something other than 0; the quotient is thrown away"
    ),
    "core/motion.py error_in_world: 1e-37 -> 1.02e-37": (
        "keeps the root of a zero vector's length above 0; any tiny number does"
    ),
    "laws/compiled.py scatter_all: 0.75 -> 0.765": (
        "one of the vertex colours that a law tries; any other is as good"
    ),
    "lights/environment.py sample: turn - 1.0 -> ((turn) + (1.0))": (
        "sine and cosine of whole turns more or less are the same"
    ),
}
