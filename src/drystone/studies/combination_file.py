"""Combinations of actions with partial factors, from a TOML file and the data of standards."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, compress, product

import numpy as np

from drystone.base.arrays import Ints
from drystone.base.display import OneLine
from drystone.base.errors import meant
from drystone.base.files import PathLike, as_path, read_bytes
from drystone.io.jsontext import Field, parse_toml, standard
from drystone.io.load_options import grown
from drystone.io.opening import kept_of
from drystone.joint_capacity import NO_LIMIT
from drystone.loads import LoadCase
from drystone.loads.applied import with_shaken_weights
from drystone.loads.case import STANDARD_GRAVITY
from drystone.loads.placing import GivenLoad
from drystone.model import Model

_KINDS = ("permanent", "variable", "accidental", "seismic")
_DIVIDED = "friction", "strength", "tie"
_MOST = 1000
"""Combinations of a file. Chosen: a quarter of an hour of small models."""


@dataclass(frozen=True, eq=False)
class Action(OneLine):
    """A case of a file of combinations.

    Attributes
    ----------
    name
    kind
        ``permanent``, ``variable``, ``accidental`` or ``seismic``.
    load
        With its characteristic value.
    psi
        Combination factors 0, 1 and 2 of a variable action.
    factors
        Unfavourable and favourable, by the names of the situations whose own they replace.
    group
        Of the variable actions of a group one acts at a time.
    together
        Variable actions of the same name are one action of several components: all lead, or none.
    beside
        Share of its value that acts beside others of ``together``.
    reversible
        Whether it acts in the opposite direction as well.
    parts
        Of its load, one for each of its words.
    """

    name: str
    kind: str
    load: LoadCase
    psi: tuple[float, float, float] = (1.0, 1.0, 1.0)
    factors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    group: str = ""
    together: str = ""
    beside: float = 1.0
    reversible: bool = False
    parts: tuple[LoadCase, ...] = ()

    def _summary(self) -> str:
        return f"'{self.name}', {self.kind}"

    @property
    def words(self) -> str:
        """Its loads, and how it acts.

        Examples
        --------
        >>> from drystone.models import tower
        >>> push = LoadCase.seismic(tower(2), 0.1)
        >>> Action("quake", "seismic", push, reversible=True, parts=(push,)).words
        'seismic 0.1, 0 g; or reversed'
        """
        told = " + ".join(one.name for one in self.parts)
        told += "; shaken" if any(one.kind == "load" for one in self.load.masses) else ""
        told += f"; one of group {self.group} at a time" if self.group else ""
        told += f"; leads with all of {self.together}" if self.together else ""
        told += f", beside them {self.beside:g} of it" if self.beside != 1.0 else ""
        return told + ("; or reversed" if self.reversible else "")

    @property
    def leads(self) -> tuple[str, str]:
        """What it leads with, alike for all that lead together."""
        return self.together, "" if self.together else self.name

    @property
    def signs(self) -> tuple[float, ...]:
        """Directions in which it acts."""
        return (1.0, -1.0) if self.reversible else (1.0,)


@dataclass(frozen=True)
class Situation(OneLine):
    """A design situation of a standard.

    Attributes
    ----------
    name
    source
    permanent
        Factors, unfavourable and favourable.
    leading, others
        Factor of the leading variable action and of those that go with it, each with the number of
        its combination factor, -1 for none.
    event
        The kind of action without which it is none: ``accidental`` or ``seismic``.
    friction, strength, tie
        By which the friction of joints, what else they carry, and the strength of ties are divided.
    by_parts
        Whether its permanent factors are those of parts of one action as well, what of it holds and
        what overturns: cases of their own here.
    """

    name: str
    source: str
    permanent: tuple[float, float]
    leading: tuple[float, int]
    others: tuple[float, int]
    event: str = ""
    friction: float = 1.0
    strength: float = 1.0
    tie: float = 1.0
    by_parts: bool = False


@dataclass(frozen=True, eq=False)
class Combination(OneLine):
    """Actions with their factors in a situation.

    Attributes
    ----------
    situation
    factors
        By the name of the action.
    load
    actions
        All of the file.
    """

    situation: Situation
    factors: Mapping[str, float]
    load: LoadCase
    actions: tuple[Action, ...]

    def _summary(self) -> str:
        return f"{self.situation.name}: {self.words}"

    @property
    def words(self) -> str:
        """Such as ``1.35 weight + 1.5 cart``."""
        each = (f"{factor:+.6g} {name}" for name, factor in self.factors.items())
        return " ".join(f"{one[0]} {one[1:]}" for one in each).removeprefix("+ ")

    @property
    def apart(self) -> tuple[LoadCase, LoadCase]:
        """Its load by the permanent actions, and by all others."""
        none = LoadCase(np.zeros_like(self.load.wrench))
        parts: tuple[list[LoadCase], list[LoadCase]] = [none], [none]
        for one in self.actions:
            factor = self.factors.get(one.name, 0.0)
            parts[one.kind != "permanent"].append(factor * one.load)
        lasting, others = (LoadCase.combine((1.0, one) for one in each) for each in parts)
        return lasting, others

    def of(self, model: Model) -> Model:
        """The model under this combination, its friction and strengths divided.

        What fill resists is divided like joints. Fill that weighs less resists less in proportion;
        that it resists more is not counted.
        """
        by = self.situation
        mine, whole = (sum(one.weight for one in load.fills) for load in (self.load, model.load))
        model = replace(model, load=replace(self.load, name=f"{by.name}: {self.words}"))
        if by.friction != 1.0:
            model = model.with_friction(model.contacts.friction / by.friction)
        capacity = model.contacts.capacity
        if capacity is None:
            return model
        fill, whole_of = model.contacts.of_fill, capacity.compression
        share = np.where(fill, mine / whole if mine < whole else 1.0, 1.0) / by.strength
        share = np.where(model.contacts.ties & ~fill, 1.0 / by.tie, share)
        left = np.where(whole_of < NO_LIMIT, share * whole_of, NO_LIMIT)
        return model.with_capacity(replace(capacity.scaled(1.0 / by.strength), compression=left))


def read_combinations(path: PathLike, model: Model) -> list[Combination]:
    """The combinations that a TOML file asks for on a model.

    Parameters
    ----------
    path
        ``standard`` (``en1990``) or tables ``[[situation]]`` as in it, ``situations`` (names; all
        that apply when left out), ``[material]`` with ``friction``, ``strength`` (of joints) and
        ``tie``: numbers by which they are divided, 1 when left out, or a class of EN 1996 such as
        ``A2``. A table ``[case.NAME]`` for each action: ``kind``; ``load``: ``gravity`` (9.81 along
        -z), ``model`` (the whole load of the model, with ``gravity``, ``load`` and ``seismic`` of
        reading), a case of its file (that of the same name when left out), ``seismic:KX,KY``,
        ``BLOCK:WHAT``, or a list of these; ``shaken``: its downward forces are weights of masses,
        which earthquakes shake as they do fill and masses in kg; ``blocks``, to which gravity is
        restricted; ``psi`` or ``category`` of variable actions; ``factors``: unfavourable and
        favourable, in place of those of situations with partial factors, or by the names of
        situations: ``factors = { STR = [1.2, 1] }``; ``group``: one of a group acts at a time;
        ``together``: a name, alike in all that lead as one action, of ``tandem``, ``udl`` and
        ``footway`` ``gr1a``; ``reversible``.
    model

    Raises
    ------
    InputError
        Something is not known, contradicts another, or has no unit; its place is named. Or a free
        block has no permanent load, or no case has the load of the model, which is not its weight,
        or a combination has the weight of a block twice.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from drystone.models import tower
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "few.toml"
    >>> _ = path.write_text('''
    ... situations = ["STR"]
    ... [case.weight]
    ... kind = "permanent"
    ... load = "gravity"
    ... [case.tank]
    ... kind = "variable"
    ... category = "E"
    ... load = "block-1:2kN"
    ... ''')
    >>> [one.words for one in read_combinations(path, Model.of(tower(2)))]
    ['1.35 weight', '1.35 weight + 1.5 tank', '1 weight', '1 weight + 1.5 tank']
    """
    top = parse_toml(read_bytes(path), as_path(path))
    top.only(("standard", "situations", "situation", "material", "case"))
    standard = _standard(top)
    every = _situations(top, standard)
    situations = _chosen(top, every)
    actions = tuple(
        _action(name, one, model, standard, every, situations) for name, one in top["case"].items()
    )
    _refuse_missing_load(top["case"], actions, model)
    _refuse_without_situation(top, actions, situations)
    made = [one for each in situations for one in _combined(each, actions)]
    if not made:
        raise top.error("gives no combination", "add cases, or situations that they belong to")
    if len(made) > _MOST:
        raise top.error(
            f"gives {len(made)} combinations, more than {_MOST}",
            "put cases that act together into one, or into groups; or name fewer situations",
        )
    _refuse_weight_twice(top["case"], actions, made, model)
    return made


def _refuse_missing_load(cases: Field, actions: Sequence[Action], model: Model) -> None:
    """Refuse blocks without permanent load, and a load of the model that the cases do not have."""
    free = model.assembly.free
    lasting = [np.abs(one.load.wrench) for one in actions if one.kind == "permanent"]
    bare = free[~np.any([one[free].any(axis=1) for one in lasting], axis=0)] if lasting else free
    if len(bare):
        raise cases.error(
            f"block '{model.assembly.names[bare[0]]}' has no permanent load, so no weight",
            'add a case with kind = "permanent" and load = "gravity"',
        )
    given = model.load.wrench[free]
    near = 1e-9 * float(np.abs(given).max(initial=0.0))
    known = [LoadCase.gravity(model.assembly), *(part for one in actions for part in one.parts)]
    known.append(LoadCase.combine((1.0, one.load) for one in actions if one.kind == "permanent"))
    if not any(np.abs(one.wrench[free] - given).max(initial=0.0) <= near for one in known):
        raise cases.error(
            f"no case has the load of the model, '{model.load.name}'",
            'write load = "model" in a case, or leave out --gravity, --seismic, --load and --case '
            "(for a load in the file: give --case weight)",
        )


def _refuse_without_situation(
    top: Field, actions: Sequence[Action], situations: Sequence[Situation]
) -> None:
    """Refuse an event that no situation calls up: it would act in no combination."""
    never = set(_KINDS[2:]) - {one.event for one in situations}
    for one in (one for one in actions if one.kind in never):
        own = f'add a [[situation]] with event = "{one.kind}"'
        remedy = own if top.has("situation") else f'add "{one.kind}" to situations'
        told = f"is {one.kind}, and no situation calls it up"
        raise top["case"][one.name].error(told, f"{remedy}, or leave the case out")


def _refuse_weight_twice(
    cases: Field, actions: Sequence[Action], made: Sequence[Combination], model: Model
) -> None:
    """Refuse combinations in which more than one load is the weight of the same block."""
    weights = {one.name: _weights(one, _words(one.name, cases[one.name]), model) for one in actions}
    for each in made:
        acting = {name: weights[name] for name in each.factors if weights[name].any()}
        twice = np.flatnonzero(sum(acting.values(), np.zeros(len(model))) > 1)
        if len(twice):
            who, down = model.assembly.names[twice[0]], LoadCase.gravity(model.assembly).wrench
            named = " and ".join(f"'{name}'" for name, one in acting.items() if one[twice[0]])
            raise cases.error(
                f"has the weight of block '{who}' twice, in {named}",
                "leave out one; a load beside weight that is as heavy is written BLOCK:WHAT: "
                f'load = "{who}:{-down[twice[0], 2]:.6g}N", or seismic:KX,KY',
            )


def _weights(action: Action, words: Sequence[Field], model: Model) -> Ints:
    """How many parts of an action are, or have, the weight of each block (n,).

    Of a case of a file that tells no acceleration: where most free blocks have their weight.
    """
    count, free = np.zeros(len(model), dtype=np.intp), model.assembly.free
    weight = LoadCase.gravity(model.assembly).wrench[free]
    known = {"model", *(case.name for case in model.cases)}
    for word, part in zip(words, action.parts, strict=True):
        alike = np.abs(part.wrench[free] - weight).max(axis=1) <= 1e-3 * np.abs(weight[:, 2])
        told = -part.acceleration[2] > 0.5 * STANDARD_GRAVITY  # less is an earthquake
        if word.text() == "gravity" or (
            word.text() in known and (told or 2 * alike.sum() > len(free))
        ):
            count[free] += part.wrench[free].any(axis=1)
    return count


_STANDARDS = ("en1990",)


def _standard(top: Field) -> Field:
    """The data of a standard."""
    name = top.get("standard", "en1990")
    if name.text() not in _STANDARDS:
        raise name.error(f"there is no standard '{name.text()}'", meant(name.text(), _STANDARDS))
    return standard(f"studies/standards/{name.text()}")


def listed(values: Iterable[float], between: str = ", ") -> str:
    """Numbers as text."""
    return between.join(f"{x:g}" for x in values)


def _gamma(one: Field) -> float:
    """A factor by which something is divided: a number, or a class of EN 1996."""
    if isinstance(one.value, str):
        table = standard("studies/standards/en1996")
        classes = {
            f"{name}{number}": float(value)
            for name, each in table["masonry"].items()
            for number, value in enumerate(each.floats(None), 1)
        }
        if one.value not in classes:
            raise one.error(f"there is no class '{one.value}'", "give A1 to C5, or a number")
        return classes[one.value]
    if one.number() < 1.0:
        raise one.error(f"is {one.number():g}", "resistance is divided by 1 or more")
    return one.number()


def _situations(top: Field, standard: Field) -> dict[str, Situation]:
    """The situations of a file, or of a standard."""
    divided = top.get("material", {})
    divided.only(_DIVIDED)
    material = {name: _gamma(one) for name, one in divided.items()}
    given = (top if top.has("situation") else standard)["situation"]
    return {one["name"].text(): _situation(one, material) for one in given.elements()}


def _chosen(top: Field, every: Mapping[str, Situation]) -> list[Situation]:
    """Those that a file asks for."""
    if not top.has("situations"):
        return list(every.values())
    chosen = []
    for one in top["situations"].elements():
        if one.text() not in every:
            raise one.error(f"there is no situation '{one.text()}'", meant(one.text(), every))
        chosen.append(every[one.text()])
    return chosen


def _situation(one: Field, material: Mapping[str, float]) -> Situation:
    factors = "permanent", "leading", "others", *_DIVIDED
    one.only(("name", "source", "event", *factors, "by_parts"))
    event = one.get("event", "")
    if event.text() not in ("", *_KINDS[2:]):
        raise event.error(f"is '{event.text()}'", "give accidental or seismic")
    divided = {name: _gamma(one[name]) for name in _DIVIDED if one.has(name)}
    return Situation(
        one["name"].text(),
        one.get("source", "").text(),
        _factors(one["permanent"]),
        _variable_pair(one["leading"]),
        _variable_pair(one["others"]),
        event.text(),
        by_parts=one.get("by_parts", False).boolean(),
        **{**material, **divided},
    )


def _variable_pair(one: Field) -> tuple[float, int]:
    """A factor, and the number of the combination factor that multiplies it, -1 for none."""
    factor, number = one.floats(2).tolist()
    if factor < 0.0 or number not in (-1, 0, 1, 2):
        raise one.error("needs a factor of zero or more, and -1, 0, 1 or 2")
    return factor, int(number)


def _factors(one: Field) -> tuple[float, float]:
    """Unfavourable and favourable."""
    bad, good = one.floats(2).tolist()
    if not 0.0 <= good <= bad:
        raise one.error(
            f"contradicts itself: {bad:g} unfavourable, {good:g} favourable",
            "give the larger one first, none below zero",
        )
    return bad, good


def _own_factors(
    one: Field, known: Field, every: Mapping[str, Situation], chosen: Sequence[Situation]
) -> dict[str, tuple[float, float]]:
    """Factors of a case, or of what is known of its category.

    A pair is for all situations with partial factors.
    """
    variable = one["kind"].text() == "variable"
    theirs = {by.name: (by.leading[0], 1.0) if variable else by.permanent for by in chosen}
    partial = {name: pair for name, pair in theirs.items() if pair[0] > 1.0 or pair[1] < 1.0}
    own = one.get("factors", {})
    if not isinstance(own.value, dict):
        pair = _factors(own)
        if not variable:
            _refuse_unless_alike(own, partial)
        return dict.fromkeys(partial, pair)
    own.only(every)
    found = dict.fromkeys(partial, (known["factor"].number(), 0.0)) if known.has("factor") else {}
    return found | {name: _factors(pair) for name, pair in own.items()}


def _refuse_unless_alike(own: Field, partial: Mapping[str, tuple[float, float]]) -> None:
    """Refuse a pair of a permanent case that is not in place of one pair of situations."""
    if len(set(partial.values())) == 1:
        return
    what = "is for no situation: all have 1 for permanent actions"
    if partial:
        told = "; ".join(f"{name} {listed(pair)}" for name, pair in partial.items())
        what = f"is one pair, and situations have different ones: {told}"
    *_, name = "NAME", *partial
    raise own.error(
        what, f"name those it replaces: factors = {{ {name} = [{listed(_factors(own))}] }}"
    )


def _action(
    name: str,
    one: Field,
    model: Model,
    standard: Field,
    every: Mapping[str, Situation],
    chosen: Sequence[Situation],
) -> Action:
    one.only(
        ("kind", "load", "shaken", "blocks", "psi", "category", "factors", "group", "together",
         "reversible")
    )  # fmt: skip
    kind = one["kind"]
    if kind.text() not in _KINDS:
        raise kind.error(f"is '{kind.text()}'", f"give {', '.join(_KINDS)}")
    _refuse_of_others(one, kind.text())
    parts = _parts(name, one, model)
    load = LoadCase.combine([(1.0, part) for part in parts], name)
    variable = kind.text() == "variable"
    known = _with_psi(one, standard) if variable else one
    return Action(
        name,
        kind.text(),
        load,
        _psi(known["psi"]) if variable else (1.0, 1.0, 1.0),
        _own_factors(one, known, every, chosen),
        _group(one, standard),
        one.get("together", known.get("together", "").value).text(),
        known.get("beside", 1.0).number(),
        one.get("reversible", False).boolean(),
        tuple(parts),
    )


def _group(one: Field, standard: Field) -> str:
    """One of a group acts at a time: no name of what acts together in the standard."""
    name = one.get("group", "").text()
    if name and name in {x.get("together", "").text() for _, x in standard["category"].items()}:
        raise one["group"].error(
            f"is '{name}', and of a group one case acts at a time",
            f'write together = "{name}" where all of {name} acts',
        )
    return name


def _refuse_of_others(one: Field, kind: str) -> None:
    """Refuse what only cases of other kinds have."""
    without = [] if kind == "variable" else ["psi", "category", "group", "together"]
    without += {"permanent": ["reversible"], "variable": []}.get(kind, ["factors"])
    for name in without:
        if one.get(name, False).value is not False:
            raise one[name].error(f"is of no {kind} case", "leave it out")


def _with_psi(one: Field, standard: Field) -> Field:
    """What has the combination factors of a variable action: itself, or its category."""
    known = standard["category"]
    if one.has("psi") == one.has("category"):
        both = "has psi and a category" if one.has("psi") else "has neither psi nor a category"
        raise one.error(both, f"give one; categories are {', '.join(known.value)}")
    if one.has("psi"):
        return one
    category = one["category"]
    if category.text() not in known.value:
        what = f"there is no category '{category.text()}'"
        raise category.error(what, meant(category.text(), known.value))
    return known[category.text()]


def _psi(one: Field) -> tuple[float, float, float]:
    values = one.floats(3)
    if not (values[0] <= 1.0 and (np.diff(values) <= 0.0).all() and values[2] >= 0.0):
        raise one.error(
            f"contradicts itself: {', '.join(f'{x:g}' for x in values)}",
            "give psi 0, 1 and 2 from 1 to 0, none above the one before",
        )
    return float(values[0]), float(values[1]), float(values[2])


def _parts(name: str, one: Field, model: Model) -> list[LoadCase]:
    """The loads of a case, at their characteristic values."""
    each = _words(name, one)
    parts = [_acting(word, one, model) for word in each]
    if one.has("blocks") and "gravity" not in [word.text() for word in each]:
        raise one["blocks"].error("restricts gravity only", 'write load = "gravity"')
    if not parts:
        raise one["load"].error("is empty", "name a load")
    return parts


def _words(name: str, one: Field) -> list[Field]:
    """Of the loads of a case."""
    given = one.get("load", name)
    return list(given.elements()) if isinstance(given.value, list) else [given]


def _acting(word: Field, one: Field, model: Model) -> LoadCase:
    """What one word of the load of a case means; the weight of blocks is shaken anyhow."""
    if word.text() == "gravity":
        return _weight(one, model)
    if word.text().startswith("train:"):
        remedy = (
            "compare its partial factor with that of drystone limit train, whose --out writes it"
        )
        raise word.error("a train is no load of a case", remedy)
    with word.blamed():
        own = word.text() == "model"
        made = model.load if own else grown(word.text(), model)
    shaken = one.get("shaken", False).boolean()
    return with_shaken_weights(model.assembly, made) if shaken else made


def _weight(one: Field, model: Model) -> LoadCase:
    """The weight of all blocks, or of those that are named."""
    whole = LoadCase.gravity(model.assembly)
    if not one.has("blocks"):
        return whole
    with one["blocks"].blamed():
        kept = kept_of(model.assembly, one["blocks"].text())
    wrench = np.zeros_like(whole.wrench)
    wrench[kept] = whole.wrench[kept]
    given = np.zeros((len(wrench), 4, 3))  # it acts at centroids, where a roof acts on top
    given[:, 0] = wrench[:, :3]
    name = f"gravity of {one['blocks'].text()}"
    return LoadCase(wrench, name, given=given, each=GivenLoad.of(name, wrench, given))


def _combined(by: Situation, actions: tuple[Action, ...]) -> Iterator[Combination]:
    """All combinations of a situation; those that are equal are given once."""
    load = {one.name: one.load for one in actions}
    known: set[tuple[tuple[str, float], ...]] = set()
    for acting in product(*_lasting(by, actions), _variable(by, actions), _events(by, actions)):
        every = chain.from_iterable(one.items() for one in acting)
        factors = {name: factor for name, factor in every if factor != 0.0}
        key = tuple((name, round(factor, 9)) for name, factor in factors.items())
        if factors and key not in known:
            known.add(key)
            parts = [(factor, load[name]) for name, factor in factors.items()]
            yield Combination(by, factors, LoadCase.combine(parts), actions)


def _lasting(by: Situation, actions: Sequence[Action]) -> list[list[dict[str, float]]]:
    """Factors of each permanent action."""
    return [
        [{one.name: factor} for factor in dict.fromkeys(one.factors.get(by.name, by.permanent))]
        for one in actions
        if one.kind == "permanent"
    ]


def _events(by: Situation, actions: Sequence[Action]) -> list[dict[str, float]]:
    """Factors of each event of the situation, which acts alone; none where it has no events."""
    if not by.event:
        return [{}]
    return [{one.name: sign} for one in actions if one.kind == by.event for sign in one.signs]


def _variable(by: Situation, actions: Sequence[Action]) -> Iterator[dict[str, float]]:
    """Factors of the variable actions that act: none, and each set with all that lead it."""
    for some in _sets([one for one in actions if one.kind == "variable"]):
        counts = Counter(one.leads for one in some)
        for lead in counts or [None]:
            each = [_factor(one, one.leads == lead, by, counts[one.leads]) for one in some]
            for signs in product(*(one.signs for one in some)):
                yield {
                    one.name: sign * factor
                    for one, sign, factor in zip(some, signs, each, strict=True)
                }


def _sets(variable: Sequence[Action]) -> Iterator[list[Action]]:
    """Those that act together: of each group one at most."""
    for present in product((False, True), repeat=len(variable)):
        some = list(compress(variable, present))
        groups = [one.group for one in some if one.group]
        if len(set(groups)) == len(groups):
            yield some


def _factor(one: Action, leads: bool, by: Situation, count: int) -> float:
    """The factor of one of a count of actions that lead together."""
    factor, number = by.leading if leads else by.others
    factor = one.factors.get(by.name, (factor,))[0]
    share = one.beside if count > 1 else 1.0
    return factor * share * (1.0 if number < 0 else one.psi[number])
