"""The sections of a report, from answers: each says of itself what is printed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import PurePath

import numpy as np

from drystone.answer import Answer, Question, Role, worst_first
from drystone.base.display import rounded_up
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.geometry.quadrature import ACCURATE
from drystone.joints import HINGED, worst_joints
from drystone.limits import Limit
from drystone.limits.train_answer import TrainEnvelope
from drystone.loads.applied import Shaken, loads_apart
from drystone.model import Model
from drystone.report import sketches
from drystone.report.document import Document, Heading, Part, Picture, Section, TitleBlock
from drystone.report.hand_checks import (
    as_one_block,
    balance,
    crown_thrusts,
    fall_words,
    least_strength,
    mechanism_table,
    weights,
)
from drystone.results import Result
from drystone.sequence import StagedModel
from drystone.studies import Combinations

_LISTED = 40
"""Rows of a table in the text; longer ones stand in an annex. Chosen: one page."""
_ANNEXED = 1000
"""Rows of a table in an annex. Chosen: some 20 pages."""
_PLANS = 8
"""Joints of which plans are drawn. Chosen: half a page."""
_METHOD = (
    "z points up. The normal force of a joint is positive in compression. Forces in joints act on "
    "block b; block a gets the opposite. Reactions act on the structure, loads on the block "
    "that is named, at their point or where their line enters it. Moments turn by the right-hand "
    "rule.",
    "Blocks are rigid and do not crack. Joints press, and carry friction by Coulomb's law with the "
    "coefficients under Materials; they pull and crush only where a capacity stands there. Ties "
    "pull, and go on pulling where they yield. Loads act once and slowly: there is no inertia, no "
    "impact and no partial factor unless it is named.",
    "STABLE: forces were found that balance every block within the friction cones, and they arise "
    "without prestress from a motion of the blocks on contact springs. UNSTABLE: a mechanism was "
    "found on which the loads do work against all joints, so that no forces can balance them; or "
    "the blocks were followed by finite steps and did not come to rest, as the answer then says. "
    "Forces and mechanisms are computed again from the points of contact; the residuals stand "
    "beside each answer. UNDECIDED: neither was found.",
)
_LIMITS = (
    "A limit is a pair of values: at the one it stands, at the other it falls; both were checked."
)


def document_of(answers: Sequence[Answer], about: TitleBlock) -> Document:
    """The report on answers about one model; the first one has the verdict."""
    first = answers[0]
    model = first.model.model if isinstance(first.model, StagedModel) else first.model
    asked = first.asked
    version = " ".join(one for one in ("drystone", asked.version, asked.commit) if one)
    governing = _governing(answers)
    limits = any(isinstance(one, Limit | TrainEnvelope) for one in answers)
    method = (*_METHOD, _LIMITS) if limits else _METHOD
    sections = [
        Section("Summary", (*_summary(answers, model), _signatures(about))),
        Section("What was asked", (_asked(answers),)),
        Section("Geometry", tuple(_geometry(model))),
        Section("Materials", tuple(_materials(model))),
        Section("Loads", tuple(_loads(model, first))),
        Section("Signs, method and assumptions", (sketches.signs_picture(), *method)),
        *(Section(one.title + _without(one, answers), tuple(_answer(one))) for one in answers),
    ]
    if governing is not None:
        checks = (*_checks(*governing, model), *_sums(answers))
        sections.append(Section("Joints and hand checks", checks))
    name = about.project or asked.file or "a model"
    entries = {**about.entries(first.when[:10]), "Calculated with": version}
    return Document(f"Stability of {name}", entries, version, _numbered(sections))


def _governing(answers: Sequence[Answer]) -> tuple[Result, Answer] | None:
    """The state whose joints are told: the worst that has other loads than the first, or that.

    With its answer.
    """
    found = ((_forces(one), one) for one in worst_first(answers))
    known = [(state, one) for state, one in found if state is not None]
    first = _forces(answers[0])
    others = [one for one in known if first is None or one[0].load.name != first.load.name]
    return next(iter([*others, *known]), None)


def _forces(answer: Answer) -> Result | None:
    """Its state with forces: of a limit the last that stands, of combinations the governing one."""
    match answer:
        case Result():
            found: Result | None = answer
        case Limit():
            found = answer.best.standing
        case TrainEnvelope():
            found = answer.standing
        case Combinations():
            found = answer.governing
        case _:
            found = None
    return None if found is None or found.force is None else found


def _numbered(sections: Sequence[Section]) -> tuple[Section, ...]:
    """Sections and pictures with numbers; long tables in annexes after them."""
    count, made = 0, []
    annexes: list[Section] = []
    for number, section in enumerate(sections, 1):
        parts: list[Part] = []
        for part in section.parts:
            if isinstance(part, Picture):
                count += 1
                part = replace(part, caption=f"Figure {count}. {part.caption}")
            if isinstance(part, Table) and len(part) > _LISTED:
                title = f"Annex {len(annexes) + 1}"
                annexes.append(Section(f"{title}  {part.title.capitalize()}", tuple(_all(part))))
                short, which = _some(part)
                parts += [short, f"The {which} {_LISTED} of {len(part):,}; all in {title}."]
                continue
            parts.append(part)
        made.append(Section(f"{number}  {section.title}", tuple(parts)))
    return (*made, *annexes)


def _some(table: Table) -> tuple[Table, str]:
    """Rows of a long table that stand in the text, and which they are."""
    if {"friction_use", "edge_ratio", "normal"} <= set(table.columns):
        return table.take(worst_joints(table, _LISTED)), "worst"
    return table.take(range(_LISTED)), "first"


def _all(table: Table) -> Iterator[Part]:
    if len(table) <= _ANNEXED:
        yield table
        return
    yield table.take(range(_ANNEXED))
    yield f"The first {_ANNEXED:,} of {len(table):,}; --csv and --json write all."


def _summary(answers: Sequence[Answer], model: Model) -> Iterator[Part]:
    yield from dict.fromkeys(line for one in worst_first(answers) for line in _told(one, answers))
    yield from _carried(model)
    if any(
        isinstance(x, TrainEnvelope) and x.model.load.fills != model.load.fills for x in answers
    ):
        yield "Only the train has fill: give that with --load, to have it in all parts."


def _without(one: Answer, answers: Sequence[Answer]) -> str:
    """What a limit beside that of a train does not have."""
    trains = any(isinstance(each, TrainEnvelope) for each in answers)
    return ", without the train" if trains and isinstance(one, Limit) else ""


def _undivided(one: Answer, answers: Sequence[Answer]) -> Iterator[str]:
    """That a limit does not have the material factors of combinations beside it."""
    several = (x.each for x in answers if isinstance(x, Combinations))
    each = {max(y.situation.friction, y.situation.strength) for x in several for y in x}
    if isinstance(one, Limit | TrainEnvelope) and max(each, default=1.0) > 1.0:
        yield "Material factors of the combinations do not divide friction and strength here"


def _told(one: Answer, answers: Sequence[Answer]) -> Iterator[str]:
    """The title of an answer, the margins of what stands, and what is to be borne in mind."""
    count = 3 if isinstance(one, Combinations) else 1  # which governs, and what happens there
    said = [*(sentence.text for sentence in one.sentences()[:count]), one.title]
    under = one.asked.facts().get("Load") if isinstance(one, Limit) else None
    said += [f"Load: {under}{_without(one, answers)}"] if under else []
    said += _undivided(one, answers)
    yield ". ".join(dict.fromkeys(said)) + "."
    margins = one.margins() if isinstance(one, Result) else ()
    for sentence in filter(lambda each: each.text, margins):
        yield f"{sentence.text[:1].upper()}{sentence.text[1:]}."
    for sentence in one.sentences()[1:]:
        if sentence.role is Role.REMARK:
            yield f"Note: {sentence.text}."


def _signatures(about: TitleBlock) -> Mapping[str, str]:
    """Lines on which the calculation is signed by hand."""
    line = "_" * 24
    rest = f"   date {line[:14]}   signature {line}"
    people = {"Calculated by": about.author, "Checked by": about.checker}
    return {what: (who or line) + rest for what, who in people.items()}


def _asked(answers: Sequence[Answer]) -> Mapping[str, str]:
    """What was asked; a question of the reader is for the screen, before anything is signed."""
    asked = answers[0].asked
    notes = (one.rpartition(": ")[0] if one.endswith("?") else one for one in asked.notes)
    asked = replace(asked, notes=tuple(x for x in notes if x != asked.earthquake.get("told")))
    told = {"SHA-256 of the file": asked.sha256}
    for one in answers:
        if isinstance(one, Combinations):
            told |= {"Cases": PurePath(one.file).name, "SHA-256 of the cases": one.sha256}
    told |= {"Version": asked.version, "Commit": asked.commit}
    return {**asked.facts(), **{name: text for name, text in told.items() if text}}


def _geometry(model: Model) -> Iterator[Part]:
    yield sketches.dimensions_picture(model)
    assembly = model.assembly
    size = assembly.bounds[:, 1] - assembly.bounds[:, 0]
    columns = {
        "block": assembly.names,
        "support": assembly.fixed,
        "size": size,
        "centroid": assembly.centroid,
        "volume": assembly.volume,
    }
    yield Table("blocks", columns, {"size": "m", "centroid": "m", "volume": "m3"})


def _materials(model: Model) -> Iterator[Part]:
    yield weights(model)
    joints = model.contacts.select(~model.contacts.ties).joints
    if not joints.count:
        yield "No blocks touch."
        return
    friction, which = np.unique(joints.friction.round(9), return_inverse=True)
    columns = {
        "friction": friction,
        "angle": np.degrees(np.arctan(friction)),
        "joints": np.bincount(which),
        "area": np.bincount(which, joints.area),
    }
    yield Table("joints by friction", columns, {"angle": "deg", "area": "m2"})
    if not (model.contacts.crushes & ~model.contacts.ties).any():
        yield "No strength in compression was given: stone is taken as infinitely strong."
    yield from _carried(model)


def _carried(model: Model) -> Iterator[str]:
    """What joints carry beyond friction, and whether they break."""
    carried = Question.of(model).facts().get("Joint capacity")
    if carried:
        yield f"Joints carry {carried}."


def _loads(model: Model, first: Answer) -> Iterator[Part]:
    if isinstance(first, Combinations):
        yield f"The actions of '{first.file}', in the combination that governs."
        model = first.governing.model
    parts = list(_applied(model))
    yield from parts
    if not isinstance(parts[-1], Table):
        yield "The model has no other load on a free block; limits and cases name what they add."
    yield sketches.loads_picture(model)
    if isinstance(first, TrainEnvelope):
        train, fill = first.train, first.fill
        yield Heading(f"The train '{train.name}'")
        yield {
            "Axles": train.words,
            "Source": train.source or "own",
            "Load factor": f"multiplies all axles, {quantity(sum(train.loads), 'N')} in all, "
            f"{'and the line load' if train.line else 'and nothing else'}; "
            "the weight of blocks and fill is not multiplied",
            "Fill": fill.words,
        }
        if len(first.places):
            yield first.axles()


def _applied(model: Model) -> Iterator[Part]:
    """The load of a model: the acceleration, what an earthquake shakes, and what else acts."""
    applied = loads_apart(model.assembly, model.load)
    along = ", ".join(f"{x:.4g}" for x in applied.acceleration + 0.0)
    more = ", all in the table" if model.load.name.endswith(" more") else ""
    yield f"Load: {model.load.name}{more}. Acceleration of all masses: {along} m/s2."
    known = Shaken.of(model.assembly, model.load)
    if known is not None:
        yield f"{known.words[:1].upper()}{known.words[1:]}."
    table = applied.table(model.assembly.names)
    yield from (table,) if len(table) else ()


def _answer(answer: Answer) -> Iterator[Part]:
    """What an answer says of itself; the loads stand in their own section."""
    for one in answer.sentences():
        if one.text.casefold() != answer.title.casefold():
            yield one.text[:1].upper() + one.text[1:]
    yield from sketches.answer_pictures(answer)
    for table in answer.tables():
        if len(table) and not table.asked:
            yield table
    limit = answer.limit if isinstance(answer, TrainEnvelope) else answer
    told = "Proof, computed again (forces by mean block weight, lengths by block size)"
    if isinstance(limit, Limit) and limit.states:
        yield Heading(told)
        sides = zip(limit.states, limit.layers().stages, strict=True)
        yield {stage.label: _proof(state) for (state, _, _), stage in sides}
        yield from _mechanism(limit.states[-1][0])
    elif isinstance(answer, Result) and (answer.residuals is not None or answer.falls):
        yield Heading(told)
        yield {"residuals" if answer.residuals is not None else "fall": _proof(answer)}
        yield from _mechanism(answer)


def _proof(state: Result) -> str:
    """The verdict on a state, and its residuals; of one that falls, what its mechanism proves."""
    told = [f"{one.name} {abs(getattr(state.residuals, one.name)):.1e}"
            for one in fields(state.residuals)] if state.residuals is not None else []  # fmt: skip
    told += [fall_words(state)] if state.falls else []
    return ", ".join([state.verdict.value, *told])


def _mechanism(state: Result) -> Iterator[Part]:
    """The blocks that move in a state that falls."""
    table = mechanism_table(state) if state.falls else None
    yield from () if table is None else (table,)


def worst_told(result: Result, count: int) -> Iterator[Part]:
    """The joints nearest to sliding or to a hinge: a table, what its columns say, their plans."""
    table = result.joints()
    ties = result.contacts.joints.ties
    worst = [i for i in worst_joints(table, count).tolist() if not ties[i]]
    shown = (
        "joint", "block_a", "block_b", "normal", "tangential", "friction_use", "kern_ratio",
        "edge_ratio", "peak_pressure", *(("strength_use",) if result.contacts.crushes.any() else ())
    )  # fmt: skip
    units = {name: unit for name, unit in table.units.items() if name in shown}
    shares = dict.fromkeys(("friction_use", "kern_ratio", "edge_ratio"), "1")
    shares |= {"strength_use": "1"} if "strength_use" in shown else {}
    told = {name: table[name] for name in shown}
    told["peak_pressure"] = np.where(told["edge_ratio"] > HINGED, np.inf, told["peak_pressure"])
    rounding = 1e-9 * float(table["normal"].max(initial=0.0))
    told["tangential"] = np.where(told["tangential"] > rounding, told["tangential"], 0.0)
    few = Table("joints nearest to sliding or to a hinge", told, {**units, **shares})
    yield few.take(worst)
    yield (
        "friction use: force and torque by what friction resists. kern ratio: above 100 % the "
        "joint opens. edge ratio: 100 % is a hinge. In the plans the joint is seen against its "
        "normal, with its kern (dashed) and the centre of pressure (dot)."
    )
    if "strength_use" in shown:
        yield "peak pressure: of a linear distribution. The strength is checked by a stress block."
    if (told["friction_use"][worst] > 1.0 + ACCURATE).any():
        yield (
            "A friction use above 100 % is of a joint that turns on its corners: pressure spread "
            "over its face would carry less torque. No corner exceeds its friction."
        )
    yield from sketches.joint_plans(result, table, worst)


def _sums(answers: Sequence[Answer]) -> Iterator[Part]:
    """The vertical load of each train by hand."""
    for one in answers:
        if isinstance(one, TrainEnvelope) and len(one.places):
            yield one.by_hand()


def _checks(result: Result, answer: Answer, model: Model) -> Iterator[Part]:
    table = result.joints()
    limit = isinstance(answer, Limit | TrainEnvelope)
    where = f"'{answer.title}'{', at the limit of collapse and not in service' if limit else ''}"
    yield f"In the state of {where}, under {result.load.name}."
    if not np.array_equal(result.load.wrench, model.load.wrench):
        yield from _applied(result.model)
    yield from worst_told(result, _PLANS)
    needed, at = least_strength(result)
    if needed > 0.0:
        a, b = (result.assembly.names[i] for i in result.contacts[at].blocks)
        row = int(result.contacts.joint[at])
        if table["edge_ratio"][row] > HINGED:
            yield (
                f"In the joint of '{a}' and '{b}' {quantity(table['normal'][row], 'N')} act on an "
                "edge, which no finite strength carries: give --strength, and crushing is counted."
            )
        else:
            yield (
                "The forces that were found need a strength of "
                f"{quantity(rounded_up(needed, 3), 'Pa')} in the joint of '{a}' and '{b}' "
                "(normal force over the stress block about its centre of pressure), and no more in "
                "any other that carries a thousandth of the largest force."
            )
    if result.model is not model:
        yield result.reactions()
    yield Heading("Hand checks")
    yield balance(result)
    whole = as_one_block(result)
    yield from () if whole is None else (whole,)
    thrusts = crown_thrusts(result)
    yield from (one.table() for one in thrusts)
    if thrusts:
        yield (
            "A thrust at a crown is a check of consistency: loads, their arms and moments are by "
            "hand; the points of the reaction and the thrust, and what is marked (found), are of "
            "the calculation. With an odd number of voussoirs one part has the whole block at the "
            "crown."
        )
    else:
        yield (
            "No thrust at a crown: no arch was recognised, of blocks over an opening that press on "
            "each other between two springings."
        )
