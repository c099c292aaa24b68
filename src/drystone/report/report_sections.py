"""The sections of a report, from answers: each says of itself what is printed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace

import numpy as np

from drystone.answer import Answer, Question, Role
from drystone.base.table import Table
from drystone.joints import worst_joints
from drystone.loads.applied import applied_loads
from drystone.model import Model
from drystone.report import sketches
from drystone.report.document import Document, Heading, Part, Picture, Section
from drystone.report.hand_checks import balance, crown_thrust, weights
from drystone.report.title_block import TitleBlock
from drystone.results import Result
from drystone.sequence import StagedModel
from drystone.view.joint_page import joint_plan

_PLANS = 8
"""Joints of which plans are drawn. Chosen: half a page."""
_METHOD = (
    "z points up. The normal force of a joint is positive in compression. Forces in joints act on "
    "block b; block a gets the opposite. Reactions act on the structure, loads on the block "
    "that is named. Moments turn by the right-hand rule.",
    "Blocks are rigid and do not crack. Joints press, and carry friction by Coulomb's law with the "
    "coefficients under Materials; they pull and crush only where a capacity stands there. Loads "
    "act once and slowly: there is no inertia, no impact and no partial factor unless it is named.",
    "STABLE: forces were found that balance every block within the friction cones, and they arise "
    "without prestress from a motion of the blocks on contact springs. UNSTABLE: a mechanism was "
    "found on which the loads do work against all joints, so that no forces can balance them. Both "
    "are computed again from the points of contact; the residuals stand beside each answer. "
    "UNDECIDED: neither was found.",
    "A limit is a pair of values: at the one it stands, at the other it falls; both were checked.",
)


def document_of(answers: Sequence[Answer], about: TitleBlock) -> Document:
    """The report on answers about one model; the first one has the verdict."""
    first = answers[0]
    model = first.model.model if isinstance(first.model, StagedModel) else first.model
    asked = first.asked
    version = " ".join(one for one in ("drystone", asked.version, asked.commit) if one)
    sections = (
        Section("Summary", tuple(_summary(answers))),
        Section("What was asked", (_asked(first),)),
        Section("Geometry", tuple(_geometry(model))),
        Section("Materials", tuple(_materials(model))),
        Section("Loads", tuple(_loads(model))),
        Section("Signs, method and assumptions", (sketches.signs_picture(), *_METHOD)),
        *(Section(one.title, tuple(_answer(one))) for one in answers),
        *(
            Section("Joints and hand checks", tuple(_checks(one)))
            for one in answers[:1]
            if isinstance(one, Result) and one.force is not None
        ),
    )
    name = about.project or asked.file or "a model"
    entries = {**about.entries(first.when[:10]), "Calculated with": version}
    return Document(f"Stability of {name}", entries, version, tuple(_numbered(sections)))


def _numbered(sections: Sequence[Section]) -> Iterator[Section]:
    """Sections whose pictures have numbers."""
    count = 0
    for section in sections:
        parts: list[Part] = []
        for part in section.parts:
            if isinstance(part, Picture):
                count += 1
                part = replace(part, caption=f"Figure {count}. {part.caption}")
            parts.append(part)
        yield replace(section, parts=tuple(parts))


def _summary(answers: Sequence[Answer]) -> Iterator[Part]:
    for one in answers:
        said = [one.sentences()[0].text, one.title]
        yield ". ".join(dict.fromkeys(said)) + "."
        for sentence in one.sentences()[1:]:
            if sentence.role is Role.REMARK:
                yield f"Note: {sentence.text}."


def _asked(first: Answer) -> Mapping[str, str]:
    asked = first.asked
    told = {
        "SHA-256 of the file": asked.sha256,
        "Version": asked.version,
        "Commit": asked.commit,
    }
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
    joints = model.contacts.joints
    if not joints.count:
        yield "No blocks touch."
        return
    rows = []
    for friction in np.unique(joints.friction.round(9)).tolist():
        mine = np.isclose(joints.friction, friction)
        rows.append((friction, np.degrees(np.arctan(friction)), int(mine.sum()), joints.area[mine]))
    columns = {
        "friction": [row[0] for row in rows],
        "angle": [row[1] for row in rows],
        "joints": [row[2] for row in rows],
        "area": [float(row[3].sum()) for row in rows],
    }
    yield Table("joints by friction", columns, {"angle": "deg", "area": "m2"})
    carried = Question.of(model).facts().get("Joint capacity")
    if carried:
        yield f"Joints carry {carried}."


def _loads(model: Model) -> Iterator[Part]:
    applied = applied_loads(model.assembly, model.load)
    along = ", ".join(f"{x:.4g}" for x in applied.acceleration + 0.0)
    yield f"Load: {model.load.name}. Acceleration of all masses: {along} m/s2."
    if len(applied.block):
        yield applied.table(model.assembly.names)
    else:
        yield "The model has no other load on a free block; a limit names those that it adds."
    yield sketches.loads_picture(model)


def _answer(answer: Answer) -> Iterator[Part]:
    """What an answer says of itself; the loads stand in their own section."""
    for one in answer.sentences():
        if one.text.casefold() != answer.title.casefold():
            yield one.text[:1].upper() + one.text[1:]
    picture = sketches.answer_picture(answer)
    if picture is not None:
        yield picture
    for table in answer.tables():
        if len(table) and table.title != "loads":
            yield table
    residuals = getattr(answer, "residuals", None)
    if residuals is not None:
        yield Heading("Proof, computed again (forces by mean block weight, lengths by block size)")
        yield {one.name: f"{abs(getattr(residuals, one.name)):.1e}" for one in fields(residuals)}


def _checks(result: Result) -> Iterator[Part]:
    table = result.joints()
    worst = worst_joints(table, _PLANS).tolist()
    shown = (
        "joint", "block_a", "block_b", "normal", "tangential", "friction_use", "kern_ratio",
        "edge_ratio", "peak_pressure",
    )  # fmt: skip
    units = {name: unit for name, unit in table.units.items() if name in shown}
    shares = dict.fromkeys(("friction_use", "kern_ratio", "edge_ratio"), "1")
    few = Table("joints nearest to sliding or to a hinge", {name: table[name] for name in shown},
                {**units, **shares}).take(worst)  # fmt: skip
    yield few
    yield (
        "friction use: force and torque by what friction resists. kern ratio: above 100 % the "
        "joint opens. edge ratio: 100 % is a hinge. In the plans the joint is seen against its "
        "normal, with its kern (dashed) and the centre of pressure (dot)."
    )
    yield tuple(joint_plan(result, table, i) for i in worst)
    yield Heading("Hand checks")
    yield balance(result)
    thrust = crown_thrust(result)
    if thrust is not None:
        yield thrust.table()
