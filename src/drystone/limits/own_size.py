"""Brackets as wide as the value of their limit allows, whatever the range of the search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

from drystone.limits.brackets import Bracket, FoundBracket
from drystone.limits.limit_checks import SEARCHED
from drystone.limits.limit_families import Family
from drystone.limits.search_settings import COARSE, FOLLOWED, Brackets, SearchSettings

BracketSearch: TypeAlias = Callable[
    [Family, tuple[float, float], Bracket, float, SearchSettings], Brackets
]


def by_its_own_size(
    family: Family,
    start: float,
    found: Brackets,
    outer: Bracket,
    width: tuple[float, float],
    means: SearchSettings,
    search: BracketSearch,
) -> Brackets:
    """Brackets searched again, where they are wide for the value of the limit.

    Their width was a share of the distance from the start to the limit of equilibrium, which may be
    much longer, or to the end of the range where forces balance everything. Of larger models this
    is done in the second case only.

    Parameters
    ----------
    family, start
    found
        Brackets of the first search.
    outer
        That of equilibrium.
    width
        The least one, and the share of the limit where blocks need not be followed.
    means
    search
        Finds brackets between two values, with a width.
    """
    large = family(start).contacts.corner_count > SEARCHED
    if large and outer.falls is not None:
        return found
    while not means.clock.late():
        uniform, rest, robust = found
        inside, falls = rest.bracket.stands, rest.bracket.falls
        if inside is None or falls is None:
            break
        size, gap = max(abs(falls), abs(inside)), abs(falls - inside)
        least = max(width[0], width[1] * size)
        told = max(least, (COARSE if large else FOLLOWED) * size)
        if gap <= told * (1.0 + 1e-9):
            break
        begin = inside if robust is None or robust.stands is None else robust.stands
        known = means.at_start if begin == start else (None, None)
        there = replace(means, at_start=known, followed=FOLLOWED * size)
        again = search(family, (begin, falls), outer, told if large else least, there)
        bracket = again[1].bracket
        if bracket.stands is None or bracket.falls is None or means.clock.late():
            break
        if again[0] is not None and again[0].bracket.falls not in (None, outer.falls):
            uniform = again[0]  # otherwise it stands at all of these values
        found = uniform, _together(rest, again[1]), again[2] or robust
        if abs(bracket.falls - bracket.stands) > 0.5 * gap:
            break  # the values between them are undecided
    return found


def _together(wide: FoundBracket, narrow: FoundBracket) -> FoundBracket:
    """The bracket of the narrow search, with what the wide one found beyond it."""
    known = {one.value: one for one in (*wide.evaluations, *narrow.evaluations)}
    evaluations = tuple(known[value] for value in sorted(known))
    return FoundBracket(narrow.bracket, (*narrow.islands, *wide.islands), evaluations)
