"""Which arms compute a different picture from the others, when nobody knows the true one.

Arms without a reference from elsewhere can only be compared with each other. The one assumption is
that *most of them are right*. Then there is a majority whose members all have the same mean
picture; the test of that majority fails with a probability of at most the level, and whoever is in
a majority that passes is not named. So an arm is named only if **every** majority that it is part
of disagrees within itself, and the probability that any right arm is named is at most the level,
whatever the wrong ones do and however many tests there are: a closed test (Marcus, Peritz and
Gabriel, On closed testing procedures with special reference to ordered analysis of variance,
Biometrika 63, 1976). Within a set of arms the p-values of all pairs are corrected by Bonferroni.

Two arms have no majority but both: that they differ is found, which of them is wrong is not.

Where no majority passes, the right one has failed, with a probability of at most the level; so what
is said then costs no level. An arm is named by the majorities that pass at the level squared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from alight.lab.results import BIASED, DISPUTED, UNBIASED
from alight.lab.statistics.block_means import LEVEL, compare_with_reference
from alight.metrics.comparison import PictureStatistics

#: Most arms that vote: there are 2^K sets of K.
MOST_VOTERS = 14


@dataclass(frozen=True)
class Vote:
    """What the comparison of arms with each other says.

    Attributes
    ----------
    p_values : dict of str to float
        By arm: of "it agrees with a majority", over all comparisons.
    verdicts : dict of str to str
        `BIASED` for arms that no agreeing majority has, `DISPUTED` for others that disagree where
        no majority decides between them, else `UNBIASED`.
    """

    p_values: dict[str, float]
    verdicts: dict[str, str]


def vote(
    arms: Mapping[str, PictureStatistics],
    references: Mapping[str, PictureStatistics],
    level: float = LEVEL,
) -> Vote:
    """Compare arms with each other, block by block.

    Parameters
    ----------
    arms : mapping of str to PictureStatistics
        Of the replicates of each arm.
    references : mapping of str to PictureStatistics
        Of references that some of the arms rendered: they represent these arms, which must agree
        with them too.
    level : float
        Largest probability that a right arm is called biased.
    """
    best = {**arms, **references}
    pairs = {
        (a, b): compare_with_reference(best[a], best[b]).p_value for a, b in combinations(arms, 2)
    }
    for name in references:
        pairs[name, name] = compare_with_reference(arms[name], references[name]).p_value
    return counted(list(arms), pairs, level)


def counted(names: Sequence[str], pairs: Mapping[tuple[str, str], float], level: float) -> Vote:
    """The vote by the p-values of all pairs.

    Parameters
    ----------
    names : sequence of str
    pairs : mapping of (str, str) to float
        Of each pair of arms; of (a, a) where an arm is compared with a reference of its own.
    level : float
    """
    sets = _majorities(names, pairs)
    p_values = {name: max(p for members, p in sets if name in members) for name in names}
    agreeing = [members for members, p in sets if p >= level]
    bar = level if agreeing else level**2
    # Where even the best majority lies below the bar, nobody is right enough to name another.
    named = {n for n, p in p_values.items() if p < bar <= max(p_values.values())}
    if agreeing:
        # The largest sets that agree: who is in all of them is beyond dispute.
        most = max(map(len, agreeing))
        settled = frozenset.intersection(*(one for one in agreeing if len(one) == most))
    else:
        differ = (pair for pair, p in pairs.items() if p * len(pairs) < level)
        settled = {*names}.difference(*(pair for pair in differ if not named.intersection(pair)))
    return Vote(
        p_values,
        {n: BIASED if n in named else UNBIASED if n in settled else DISPUTED for n in names},
    )


def _majorities(
    names: Sequence[str], pairs: Mapping[tuple[str, str], float]
) -> list[tuple[frozenset[str], float]]:
    """All sets of more than half of the arms, and the p-value of "they agree"."""
    ordered = sorted(pairs.items(), key=lambda item: item[1])
    found = []
    for size in range(len(names) // 2 + 1, len(names) + 1):
        for chosen in combinations(names, size):
            members = frozenset(chosen)
            inside = [p for (a, b), p in ordered if a in members and b in members]
            found.append((members, min(1.0, len(inside) * inside[0]) if inside else 1.0))
    return found
