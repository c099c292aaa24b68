"""Loads, friction and imposed displacements of compas_dem: its ``Problem`` and ``Analysis``.

Source: the files that compas_dem 0.5 (a ``Problem`` holds its model and one set of conditions) and
0.6 (an ``Analysis`` holds a model and problems, each with groups of conditions) write. The loads of
a problem act together and become one load case with the weight, in newtons and metres, since its
solvers add the weight. Its displacements become another one: only a settlement answers for them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import FARTHEST, Floats
from drystone.geometry.polygon import area_vector
from drystone.io.compas_contacts import data_of
from drystone.io.draft import Draft, Extras
from drystone.io.jsontext import Field
from drystone.loads import STANDARD_GRAVITY, LoadCase


def with_problems(model: Draft, nodes: Sequence[str], problems: Sequence[Field]) -> Draft:
    """The draft of a block model with the friction, supports and loads of its problems.

    Parameters
    ----------
    model
    nodes
        Node of each of its blocks.
    problems
        Data of the problems. The first one gives friction and supports.
    """
    position = {node: i for i, node in enumerate(nodes)}
    conditions = [[*_groups(problem)] for problem in problems]
    motions = [_motions(groups, position) for groups in conditions]
    friction, notes = _friction(problems[0]) if problems else (None, [])
    if len(problems) > 1:
        notes.append(f"friction and supports are those of the first of {len(problems)} problems")
    held = motions[0] if motions else {}
    law = {} if friction is None else {"friction": friction}
    shapes = tuple(
        replace(shape, fixed=shape.fixed or i in held, metadata={**shape.metadata, **law})
        for i, shape in enumerate(model.shapes)
    )
    every = [*zip(problems, conditions, motions, strict=True)]
    if model.finish is None and not any(_is_loaded(g) or _moves(m) for _, g, m in every):
        return replace(model, shapes=shapes, notes=(*model.notes, *notes))

    def finish(assembly: Assembly, scale: float) -> Extras:
        contacts, _, results = model.finish(assembly, scale) if model.finish else (None, (), ())
        if contacts is not None and friction is not None:
            contacts = contacts.with_friction(friction)
            results = tuple(
                replace(one, model=one.model.with_friction(friction)) for one in results
            )
        cases = [
            case
            for number, one in enumerate(every)
            for case in _cases(*one, number, assembly, position)
        ]
        if cases and cases[0].motion is not None:
            cases.insert(0, LoadCase.gravity(assembly))
        return contacts, tuple(cases), results

    return Draft(shapes, "m", finish, (*model.notes, *notes))


def _moves(motion: Mapping[int, Floats]) -> bool:
    return bool(np.any([*motion.values()]))


def _cases(
    problem: Field,
    groups: Sequence[Field],
    motion: Mapping[int, Floats],
    number: int,
    assembly: Assembly,
    position: dict[str, int],
) -> Iterator[LoadCase]:
    """The load case of a problem, and one of its displacements, where it has them."""
    name = problem.get("name", "").text() or f"problem-{number}"
    if _is_loaded(groups):
        weight = LoadCase.gravity(assembly, _gravity(groups))
        loads = [one for group in groups for one in _loads(group, assembly, position)]
        yield LoadCase.combine([(1.0, one) for one in (weight, *loads)], name)
    if _moves(motion):
        moves = [(1.0, LoadCase.settlement(assembly, i, by)) for i, by in motion.items()]
        yield LoadCase.combine(moves, f"{name}-displacements")


def _groups(problem: Field) -> Iterator[Field]:
    """Data of the groups of conditions of a problem: several, or one in compas_dem 0.5."""
    conditions = problem.get("boundary_conditions", [])
    listed = isinstance(conditions.value, list)
    yield from map(data_of, conditions.elements() if listed else [conditions])


def _entries(group: Field, key: str) -> Iterator[Field]:
    yield from map(data_of, group.get(key, []).elements())


def _friction(problem: Field) -> tuple[float | None, list[str]]:
    """Friction coefficient of a problem, and remarks on what of its contact law is not read."""
    if not problem.has("contact_properties"):
        return None, []
    properties = data_of(problem["contact_properties"])
    if not properties.has("contact_model"):
        return None, []
    law = data_of(properties["contact_model"])
    glue = [key for key in ("c", "t_c") if law.has(key) and law[key].number()]
    notes = ["cohesion and tensile strength of the contacts are left out"] if glue else []
    if law.has("mu"):
        friction = law["mu"].number()
    elif law.has("phi"):
        friction = float(np.tan(np.deg2rad(law["phi"].number())))
    else:
        return None, notes
    if not 0.0 <= friction < np.inf:
        raise law.error(f"has a friction coefficient of {friction:g}", "give zero or more")
    return friction, notes


def _block(entry: Field, position: dict[str, int]) -> int:
    node = entry["block_index"].integer()
    if str(node) not in position:
        raise entry["block_index"].error(f"{node} is no block", "give a node of the model's graph")
    return position[str(node)]


def _motions(groups: Sequence[Field], position: dict[str, int]) -> dict[int, Floats]:
    """Motion (6,) [m, rad] of each block that is held or moved; what is not given is zero."""
    motions: dict[int, Floats] = {}
    for group in groups:
        for entry in _entries(group, "displacements"):
            motion = motions.setdefault(_block(entry, position), np.zeros(6))
            for key, start in (("translation", 0), ("rotation", 3)):
                if entry.has(key):
                    given = [one.value or 0.0 for one in entry[key].elements()]
                    told = Field(given, entry[key].path, entry.file)
                    motion[start : start + 3] += told.floats(3)
    return motions


def _is_loaded(groups: Sequence[Field]) -> bool:
    keys = ("body_forces", "point_loads", "surface_loads")
    return any(group.get(key, []).value for group in groups for key in keys) or (
        _gravity(groups) != STANDARD_GRAVITY
    )


def _gravity(groups: Sequence[Field]) -> float:
    given = [group["g"].number() for group in groups if group.has("g")]
    return given[0] if given else STANDARD_GRAVITY


def _loads(group: Field, assembly: Assembly, position: dict[str, int]) -> Iterator[LoadCase]:
    """The loads of a group. Loads on supports have no effect and are left out."""
    for entry in group.get("body_forces", []).elements():
        given = entry if isinstance(entry.value, list) else data_of(entry)["acceleration"]
        wrench = np.zeros((len(assembly), 6))
        wrench[:, :3] = assembly.mass[:, None] * given.floats(3)
        yield LoadCase(wrench, "body force")
    for key, load in _LOADS.items():
        for entry in _entries(group, key):
            block = _block(entry, position)
            if not assembly.fixed[block]:
                yield from load(entry, assembly, block)


def _point(entry: Field, assembly: Assembly, block: int) -> Iterator[LoadCase]:
    at = entry["point"].floats(3) if entry.has("point") else None
    yield LoadCase.point_load(assembly, block, entry["force"].floats(3), at)
    if entry.has("moment"):
        yield LoadCase.moment(assembly, block, entry["moment"].floats(3))


def _surface(entry: Field, assembly: Assembly, block: int) -> Iterator[LoadCase]:
    """A traction [Pa] on a face, or in compas_dem 0.5 on a polygon of its own."""
    if entry.has("face_index"):
        face = entry["face_index"].integer()
        yield LoadCase.surface_load(assembly, block, entry["load"].floats(3), [face])
        return
    points = data_of(entry["polygon"])["points"].elements()
    corners = np.array([data_of(point).floats(3) for point in points]).reshape(-1, 3)
    if not np.abs(corners).max(initial=0.0) <= FARTHEST:
        raise entry["polygon"].error("has a coordinate that is far too large")
    area = area_vector(corners) if len(corners) > 2 else np.zeros(3)
    size = float(np.linalg.norm(area))
    if size == 0.0:
        raise entry["polygon"].error("has no area")
    along = entry["direction"].floats(3) if entry.has("direction") else area / size
    force = entry["magnitude"].number() * size * along
    yield LoadCase.point_load(assembly, block, force, corners.mean(axis=0))


_LOADS: dict[str, Callable[[Field, Assembly, int], Iterator[LoadCase]]] = {
    "point_loads": _point,
    "surface_loads": _surface,
}
