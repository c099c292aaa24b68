"""Mends of a structure: what is asked for, and what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from drystone.answer import Answer, Scene, Sentence
from drystone.base.display import named, shortened
from drystone.base.errors import InputError, counted
from drystone.base.settings import Options
from drystone.design.bench import Tried
from drystone.design.changed import Changed
from drystone.design.diagnosed import Diagnosis
from drystone.design.margin import DesignMargin
from drystone.design.mend_kinds import KINDS
from drystone.model import Model


@dataclass(frozen=True)
class MendOptions(Options):
    """Options of :func:`find_mends` and of :func:`drystone.design.mend`.

    Attributes
    ----------
    margin
        The safety margin of the mended structure.
    kinds
        Kinds of mends to try, of support, prop, tie, friction, turn, wedge, let-in, thicker,
        ballast, glue and merge; all when left out.
    keep
        Positions of blocks that may not be changed, and texts that name them, read like supports:
        names and patterns, separated by commas; see ``drystone.supports.select``. Their joints
        are not changed either; what is added may touch them.
    """

    margin: DesignMargin = field(default_factory=DesignMargin)
    kinds: tuple[str, ...] = KINDS
    keep: tuple[int | str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        kinds = _several(self.kinds, str, "kinds")
        keep = _several(self.keep, int | str, "keep")
        for kind in kinds:
            if kind not in KINDS:
                raise InputError(
                    f"there is no kind of mend '{kind}'", remedy=f"choose from {', '.join(KINDS)}"
                )
        if not kinds:
            raise InputError("no kind of mend is allowed", remedy="leave kinds out for all")
        object.__setattr__(self, "kinds", kinds)
        object.__setattr__(self, "keep", keep)


def _several(given: Any, kind: Any, name: str) -> tuple[Any, ...]:
    """One value or several of a kind, as a tuple."""
    if isinstance(given, kind) and not isinstance(given, bool):
        return (given,)
    remedy = "give names" if kind is str else "give names or positions of blocks"
    if not isinstance(given, list | tuple):
        raise InputError(f"{name} is {shortened(repr(given), 60)}", remedy=remedy)
    for one in given:
        if not isinstance(one, kind) or isinstance(one, bool):
            raise InputError(f"{name} has {shortened(repr(one), 60)}", remedy=remedy)
    return tuple(given)


@dataclass(frozen=True, eq=False)
class Mends(Answer):
    """The mends of every region of a structure.

    Attributes
    ----------
    diagnosis
        Of the structure, or of the first case of the margin in which it falls.
    mends
        Each has one change. Per region, in order of cost; of equal cost and kind the smallest
        value first.
    tried
        Kinds that do not hold a region, by the names of its blocks.
    message
        Why there is nothing to mend; empty otherwise.
    """

    diagnosis: Diagnosis
    mends: tuple[Changed, ...]
    tried: tuple[tuple[tuple[str, ...], Tried], ...] = ()
    message: str = ""

    def _summary(self) -> str:
        return self.message or f"{counted(len(self.mends), 'mend')}"

    def of(self, blocks: Sequence[str]) -> tuple[Changed, ...]:
        """The mends of the region with these blocks."""
        return tuple(mend for mend in self.mends if set(mend.change.blocks) == set(blocks))

    @property
    def model(self) -> Model:
        """The structure."""
        return self.diagnosis.model

    @property
    def title(self) -> str:
        """How many mends there are."""
        return self.message or f"{self.diagnosis.title}; {counted(len(self.mends), 'mend')}"

    def sentences(self) -> Sequence[Sentence]:
        """Why it falls, the mends, and the kinds that do not help."""
        said = [*self.diagnosis.sentences(), Sentence(self.message)]
        for number, one in enumerate(self.mends, 1):
            kept = one.change
            told = f"mend {number}, of {named(kept.blocks)}: {kept.description}"
            said.append(Sentence(f"{told} (cost {kept.cost:.3g})"))
        for blocks, failed in self.tried:
            told = f"no solution for {named(blocks)}: {failed.kind}: {failed.what}"
            said.append(Sentence(told))
        return [one for one in said if one.text]

    def layers(self) -> Scene:
        """Why it falls; each mend has a picture of its own."""
        return self.diagnosis.layers()

    def numbers(self) -> Mapping[str, Any]:
        """The diagnosis, the mends, and the kinds that do not help."""
        return {
            **self.diagnosis.numbers(),
            "mends": [mend.as_mend() for mend in self.mends],
            "tried": [
                {"blocks": blocks, "kind": one.kind, "what": one.what} for blocks, one in self.tried
            ],
            "mending": self.message,
        }
