"""An answer without an analysis: what was written, listed or compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NoReturn

from drystone.answer.answer import Answer
from drystone.answer.question import Question
from drystone.answer.sentences import Sentence
from drystone.base.errors import InputError
from drystone.base.table import Table


@dataclass(frozen=True, eq=False)
class Statement(Answer):
    """Sentences, tables and values, without a model and without a picture.

    Attributes
    ----------
    told
        The first one is the verdict.
    listed
    values
    """

    told: tuple[Sentence, ...]
    listed: tuple[Table, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)

    def _summary(self) -> str:
        return self.title

    @property
    def title(self) -> str:
        """The first sentence."""
        return self.told[0].text

    def sentences(self) -> Sequence[Sentence]:
        """Those that it was made of."""
        return self.told

    def tables(self) -> Sequence[Table]:
        """Those that it was made of."""
        return self.listed

    def layers(self) -> NoReturn:
        """Refuse: it has no picture."""
        raise InputError("has no picture", where=self.title, remedy="draw what it is about")

    def numbers(self) -> Mapping[str, Any]:
        """The values that it was made of."""
        return self.values

    @property
    def model(self) -> NoReturn:
        """Refuse: it has none."""
        raise InputError("has no model", where=self.title, remedy="ask what it is about")

    @cached_property
    def asked(self) -> Question:
        """The version and the date."""
        return Question.of_nothing(self.options, self.when)
