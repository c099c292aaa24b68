"""The JSON schema of drystone: assembly, contacts, loads and results, exact to the last bit.

Documented in ``docs/reference/formats.md``. Numbers are written as the shortest decimals that
read back as the same float64.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly
from drystone.base.errors import FormatError, InputError
from drystone.contacts import Contacts
from drystone.detection import DetectionOptions
from drystone.io.draft import Draft, DraftBlock, Extras
from drystone.io.jsontext import Field
from drystone.io.load_options import load_of_parts
from drystone.joint_capacity import DRY, JointCapacity
from drystone.loads import LoadCase
from drystone.loads.applied import common_acceleration, other_loads
from drystone.loads.placing import CarriedMass, GivenLoad, SurfaceLoad
from drystone.model import Model
from drystone.results import Residuals, Result, Samples, Sensitivity, Verdict

SCHEMA = "drystone"
VERSION = 1
TOP = ("schema", "version", "units", "blocks", "contacts", "detection", "ends", "loads", "results")
BLOCK = ("name", "vertices", "faces", "fixed", "density", "metadata", "repairs")
CONTACTS = ("block_a", "block_b", "frame", "area", "friction", "point", "interface")
LOAD = (
    *("name", "wrench", "motion", "acceleration", "shake", "masses", "given", "surface", "notes"),
    "parts",
)
ARRAYS: dict[str, tuple[int, ...]] = {
    **dict.fromkeys(("force", "force_with_props"), (3,)),
    "tension": (),
    **dict.fromkeys(("displacement", "mechanism", "prop"), (6,)),
}
"""Columns of the arrays of a result; none of a plain vector."""
TEXTS = ("message", "tilt_about", "stopped", "solver")
NUMBERS = ("eta", "tilt_margin", "friction_margin", "crushing_factor")
PLAIN = ("method", "verdict", "falling", "samples", "residuals", "options", "iterations", "time_s")
"""The rest of a result as JSON has it, beside its load and what its verdict depends on."""
RESULT = (*PLAIN, *TEXTS, *NUMBERS, *ARRAYS, "load", "sensitive_to")
_HEAVIEST = 1e9
"""[kg/m3], chosen: denser than any material; keeps products of masses finite."""


def read(top: Field) -> Draft:
    """The draft of a file in this schema, or in its minimal form with blocks only."""
    if "schema" in top.value and top["schema"].text() != SCHEMA:
        raise top["schema"].error(f"must be '{SCHEMA}'")
    if "blocks" not in top.value:
        raise top.error(
            "has no 'blocks'",
            'the minimal form is {"blocks": [{"name", "vertices", "faces", "fixed"}]}',
        )
    version = top.get("version", VERSION)
    if version.integer() > VERSION:
        raise version.error(f"is {version.value}", "a newer drystone wrote this file; update")
    top.only(TOP)
    shapes = tuple(_shape(field) for field in top["blocks"].elements())
    if not shapes:
        raise top["blocks"].error("holds no block", "give at least one")
    units = top["units"].text() if top.has("units") else None
    more = any(top.has(key) for key in ("contacts", "loads", "results"))
    if more and units not in (None, "m"):
        raise top["units"].error("must be 'm' in a file with contacts, loads or results")

    def finish(assembly: Assembly, _: float) -> Extras:
        return _extras(top, assembly)

    ends = top["ends"].text() if top.has("ends") else None
    detection = detection_of(top["detection"]) if top.has("detection") else None
    unit = "m" if more else units
    return Draft(shapes, unit, finish if more else None, ends=ends, detection=detection)


def detection_of(field: Field) -> DetectionOptions:
    """The tolerances with which the contacts of a file were searched; others are the defaults."""
    field.only(tuple(one.name for one in dataclasses.fields(DetectionOptions)))
    with field.blamed():
        return DetectionOptions(**field.value)


def _shape(field: Field) -> DraftBlock:
    field.only(BLOCK)
    density = field.get("density", DEFAULT_DENSITY)
    if not 0.0 < density.number() <= _HEAVIEST:
        raise density.error(f"is {density.value}", f"give kg/m3 above zero, at most {_HEAVIEST:g}")
    vertices = field["vertices"].floats(None, 3)
    name = field["name"].text()
    if not name:
        raise field["name"].error("is empty", "give the block a name")
    return DraftBlock(
        name,
        vertices,
        [_loop(face, len(vertices)) for face in field["faces"].elements()],
        where=field.path,
        density=density.number(),
        fixed=field.get("fixed", False).boolean(),
        metadata=field.get("metadata", {}).object().value,
        repairs=tuple(repair.text() for repair in field.get("repairs", []).elements()),
    )


def _loop(face: Field, count: int) -> list[int]:
    corners = face.value
    if isinstance(corners, list) and all(type(c) is int and 0 <= c < count for c in corners):
        return corners
    loop = [corner.integer() for corner in face.elements()]
    for i, corner in enumerate(loop):
        if not 0 <= corner < count:
            raise face.error(
                f"is no vertex: {corner}", f"they go from 0 to {count - 1}", at=f"[{i}]"
            )
    return loop


def _extras(top: Field, assembly: Assembly) -> Extras:
    contacts = _contacts(top["contacts"], assembly) if top.has("contacts") else None
    loads = tuple(_load(field, assembly) for field in top.get("loads", []).elements())
    results = []
    for field in top.get("results", []).elements():
        if contacts is None:
            raise field.error("has no contacts to refer to", "give 'contacts' as well")
        results.append(_result(field, assembly, contacts, loads))
    return contacts, loads, tuple(results)


def _contacts(field: Field, assembly: Assembly) -> Contacts:
    field.only((*CONTACTS, *DRY, "brittle", "rod"))
    block_a, block_b = field["block_a"].integers(None), field["block_b"].integers(None)
    m = len(block_a)
    for side, values in (("block_a", block_a), ("block_b", block_b)):
        bad = np.flatnonzero((values < 0) | (values >= len(assembly)))
        if len(bad):
            raise field[side].error(f"is no block: {values[bad[0]]}", at=f"[{bad[0]}]")
    try:
        return Contacts(
            block_a,
            block_b,
            field["frame"].floats(m, 3, 3),
            field["area"].floats(m),
            field["friction"].floats(m),
            field["point"].floats(None, 3),
            field["interface"].integers(None),
            _capacity(field, m),
            field["rod"].floats(m) if field.has("rod") else np.zeros(0),
        )
    except FormatError:
        raise
    except InputError as error:
        raise field.error(error.what, error.remedy) from error


def _capacity(field: Field, count: int) -> JointCapacity | None:
    """What joints carry beyond friction, where the file says so."""
    if not any(field.has(name) for name in DRY):
        return None
    given = {
        name: field[name].floats(count) if field.has(name) else np.full(count, dry)
        for name, dry in DRY.items()
    }
    brittle = field["brittle"].boolean() if field.has("brittle") else True
    return JointCapacity(**given, brittle=brittle)


def _load(field: Field, assembly: Assembly) -> LoadCase:
    field.only(LOAD)
    name = field.get("name", "load").text()
    if field.has("parts"):
        for key in LOAD[1:-1]:
            if field.has(key):
                raise field.error(f"has both a {key} and parts", "leave one out")
        return load_of_parts(field["parts"], assembly, name)
    n = len(assembly)
    motion = field["motion"].floats(n, 6) if field.has("motion") else None
    acceleration, shake = (
        field[key].floats(3) if field.has(key) else np.zeros(3) for key in ("acceleration", "shake")
    )
    surface = _surface(field["surface"], n) if field.has("surface") else None
    masses = tuple(_masses(one, n) for one in field.get("masses", []).elements())
    given = field["given"].floats(n, 4, 3) if field.has("given") else None
    wrench = field["wrench"].floats(n, 6)
    read = LoadCase(
        wrench, name, motion=motion, acceleration=acceleration, surface=surface, masses=masses,
        shake=shake, given=given, notes=tuple(x.text() for x in field.get("notes", []).elements()),
    )  # fmt: skip
    others, _ = other_loads(assembly, read.beside_masses, common_acceleration(assembly, read))
    return replace(read, each=GivenLoad.of(name, others, given))


def _masses(field: Field, n: int) -> CarriedMass:
    field.only(("kind", "mass", "moment", "gravity", "shake"))
    gravity, shake = (field[key].floats(3) for key in ("gravity", "shake"))
    return CarriedMass(
        field["kind"].text(), field["mass"].floats(n), field["moment"].floats(n, 3), gravity, shake
    )


def _surface(field: Field, n: int) -> SurfaceLoad:
    field.only(("block", "point", "traction", "wrench"))
    block = field["block"].integers(None)
    if len(block) and not 0 <= block.min() <= block.max() < n:
        raise field["block"].error(f"is not below {n}", "give positions of blocks")
    point, traction = (field[key].floats(len(block), 2, 3) for key in ("point", "traction"))
    return SurfaceLoad(block, point, traction, field["wrench"].floats(n, 6))


def _result(
    field: Field, assembly: Assembly, contacts: Contacts, loads: Sequence[LoadCase]
) -> Result:
    field.only((*RESULT, "stiffness_ratio"))  # which older files have
    position = field["load"].integer()
    if not 0 <= position < len(loads):
        raise field["load"].error(f"is no load: {position}", f"there are {len(loads)}")
    verdict = field["verdict"]
    if verdict.text() not in {v.value for v in Verdict}:
        raise verdict.error("is no verdict", f"use one of {', '.join(v.value for v in Verdict)}")
    samples = field.get("samples", {})
    samples.only(("tried", "standing"))
    falling = tuple(one.integer() for one in field.get("falling", []).elements())
    if any(not 0 <= i < len(assembly) for i in falling):
        raise field["falling"].error("has a block that does not exist")
    rows = dict.fromkeys(("force", "force_with_props", "tension"), contacts.corner_count)
    sensitive = [one.text().upper() for one in field.get("sensitive_to", []).elements()]
    if not set(sensitive) <= set(Sensitivity.__members__):
        words = ", ".join(name.lower() for name in Sensitivity.__members__)
        raise field["sensitive_to"].error("names what is not known", f"use some of {words}")
    told: dict[str, Any] = {name: field.get(name, "").text() for name in TEXTS}
    told |= {name: field[name].number() for name in NUMBERS if field.has(name)}
    for name, columns in ARRAYS.items():
        if field.has(name):
            told[name] = field[name].floats(rows.get(name, len(assembly)), *columns)
    return Result(
        method=field["method"].text(),
        verdict=Verdict(verdict.value),
        model=Model(assembly, contacts, loads[position]),
        falling=falling,
        samples=Samples(samples.get("tried", 0).integer(), samples.get("standing", 0).integer()),
        residuals=_residuals(field["residuals"]) if field.has("residuals") else None,
        options=field.value.get("options"),
        iterations=field.get("iterations", 0).integer(),
        time_s={key: value.number() for key, value in field.get("time_s", {}).items()},
        sensitive_to=tuple(Sensitivity[name] for name in sensitive),
        **told,
    )


def _residuals(field: Field) -> Residuals:
    names = tuple(f.name for f in dataclasses.fields(Residuals))
    field.only(names)
    return Residuals(**{name: field.get(name, 0.0).number() for name in names})
