"""The answers of an assessment: the verdict, why it falls, and the limits that are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Unpack

from drystone.answer import Answer
from drystone.base.files import PathLike
from drystone.base.progress import Clock, Progress, Stop
from drystone.base.settings import checked_call
from drystone.design import DiagnosisOptions, diagnose
from drystone.io.opening import Given, How, supported_model
from drystone.limits.bounds import with_margins
from drystone.stability import CheckOptions, check
from drystone.studies import combinations, read_combinations
from drystone.studies.limit_words import limit_of_words

SENSITIVITY = ("friction --scaled", "shrink")
"""Limits of what stands, if none are asked for: by which share friction and joints may shrink, and
strengths where there are some."""


@checked_call
def assess(
    given: Given,
    *,
    limits: Sequence[str] | None = None,
    cases: PathLike | None = None,
    options: CheckOptions | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> list[Answer]:
    """The verdict on a model, why it falls if it does, and limits.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    limits
        Each as behind ``drystone limit``, such as ``tilt --axis y`` or ``load keystone:1kN``; when
        left out, those of friction and of the size of joints of what stands.
    cases
        File of combinations; see :func:`drystone.studies.combinations`.
    options
        Of the check.

    Raises
    ------
    InputError
        There is no such limit, or it takes no such option.

    Examples
    --------
    >>> from drystone.models import tower
    >>> [one.title for one in assess(tower(2), limits=["tilt"], friction=0.6)]
    ['Stands', 'Stands up to 30.93 degrees about x']
    """
    model = supported_model(given, **how)
    strength = () if model.contacts.capacity is None else ("strength",)
    varied = (*SENSITIVITY, *strength) if limits is None else limits
    asked = [limit_of_words(words, model) for words in varied]
    if cases is not None:
        read_combinations(cases, model)  # refused before the work
    clock = Clock(time_limit_s, stop)
    late: dict[str, Any] = {"progress": progress, "stop": clock.late}
    result = check(model, options=options, **late)
    answers: list[Answer] = [with_margins(result, clock.late)]
    if result.falls:
        few = DiagnosisOptions(needs=False, regions=3)
        answers.append(diagnose(model, result=result, options=few, stop=clock.late))
    if result.stable or limits is not None:
        answers += [one(model, late) for one in asked]
    if cases is not None:
        answers.append(combinations(model, cases, **late))
    return answers
