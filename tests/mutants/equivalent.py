"""Slips of the campaign that change nothing that is promised, each with its reason."""

#: Name of the mutant, as the campaign prints it: why no test could find it.
EQUIVALENT: dict[str, str] = {}
