"""Subsets of structures with their verdicts, for learners: written shard by shard, and continued.

Each order of removal is a random walk from the complete structure: one of the highest blocks goes,
and with it what is no longer connected to a support. The reverse is an order of assembly. A record
is one order with the answers about its stages; records are on the disk before more are computed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, Unpack

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.answer.drawing import bare_scene
from drystone.base.arrays import Bools, Floats, frozen
from drystone.base.display import OneLine
from drystone.base.errors import FormatError, InputError, counted
from drystone.base.files import PathLike, as_path, shipped, write_text
from drystone.base.journal import Journal
from drystone.base.settings import Clock, Options, checked_call
from drystone.base.table import Table
from drystone.base.version import version
from drystone.base.workers import WorkerPool
from drystone.io import write
from drystone.io.opening import Given, How, LongHow, supported_model
from drystone.model import Model
from drystone.results import Verdict
from drystone.sequence.evaluation import fingerprint
from drystone.sequence.planner import plan
from drystone.sequence.stages import StagedModel, mask_of, members
from drystone.sequence.structure import Structure

TOGETHER, SHARD = 500, 512
"""Subsets of one structure that a worker answers about, at least, which know what is known of the
others; and orders in a file. Chosen: some seconds of work, and some megabytes. Measured: with eight
orders, of 7 and 11 subsets, an arch and a bridge have a quarter as many rows a second."""

Stages: TypeAlias = list[tuple[list[int], list[int]]]
"""Blocks placed at each step of an order of assembly, and those held after it."""


@dataclass(frozen=True)
class DatasetOptions(Options):
    """Options of :func:`dataset`.

    Attributes
    ----------
    rows : >= 1
        Least number of subsets of each structure.
    seed : >= 0
        The same seed gives the same data.
    width : >= 1
        The next block to go is one of so many highest.
    held : >= 0, <= 1
        Share of the subsets in which one block, drawn at random, is held.
    planned
        Whether the first order of each structure is that of the planner, where it has one.
    robust
        Whether other contact stiffnesses are tried; see :class:`drystone.Structure`.
    each_s : [s] >= 0
        Time limit of every check; what is not decided until then is UNDECIDED.
    """

    rows: int = 1000
    seed: int = 0
    width: int = 16
    held: float = 0.0
    planned: bool = False
    robust: bool = False
    each_s: float = float("inf")


class BuiltOrder(NamedTuple):
    """An order of assembly of a structure of a data set, and the answers about its stages.

    Attributes
    ----------
    structure
        Its number.
    planned
        Whether it is that of the planner.
    order
        Positions of the blocks that are placed at each step, s steps; supports are in place.
    held
        Positions of the blocks that are held after each step.
    verdict
        Of each stage.
    friction_left : (s,)
        Share of friction left, 0 to 1; 0 if it falls, NaN if undecided.
    falling
        Positions of the blocks that fall.
    """

    structure: int
    planned: bool
    order: tuple[tuple[int, ...], ...]
    held: tuple[tuple[int, ...], ...]
    verdict: tuple[Verdict, ...]
    friction_left: Floats
    falling: tuple[tuple[int, ...], ...]

    def masks(self, model: Model) -> Bools:
        """The blocks in place (s, n) after each step, in a model of the structure."""
        return _in_place(self.order, model)


@dataclass(frozen=True, eq=False)
class Dataset(Answer):
    """A data set in a folder.

    Attributes
    ----------
    folder
    names
        Of the structures.
    structures
    orders
        With their answers, structure by structure.
    options
    """

    folder: Path
    names: tuple[str, ...]
    structures: tuple[Model, ...]
    orders: tuple[BuiltOrder, ...]
    options: DatasetOptions = field(kw_only=True)

    @property
    def model(self) -> Model:
        """The first structure."""
        return self.structures[0]

    @property
    def rows(self) -> int:
        """Number of subsets."""
        return sum(len(one.order) for one in self.orders)

    @property
    def title(self) -> str:
        """How much it has."""
        return f"{counted(self.rows, 'subset')} of {counted(len(self.structures), 'structure')}"

    def sentences(self) -> Sequence[Sentence]:
        """How much it has, and whether that is all."""
        said = [Sentence(self.title, Role.UNSURE if self.stopped else Role.GOOD)]
        if self.stopped:
            said.append(Sentence(f"not complete: {self.stopped}; the same call goes on"))
        return said

    @cached_property
    def _table(self) -> Table:
        rows = [self._row(number) for number in range(len(self.structures))]
        columns = {key: [row[key] for row in rows] for key in rows[0]}
        return Table("structures", columns)

    def _row(self, number: int) -> dict[str, Any]:
        """What there is of a structure."""
        mine = [one for one in self.orders if one.structure == number]
        said = [verdict for one in mine for verdict in one.verdict]
        left = np.concatenate([np.zeros(0), *(one.friction_left for one in mine)])
        stood = np.array([one is Verdict.STABLE for one in said], dtype=bool)
        return {
            "structure": self.names[number],
            "blocks": len(self.structures[number]),
            "orders": len(mine),
            "subsets": len(said),
            "distinct": len({stage for one in mine for stage in _stages(one)}),
            **{verdict.value: said.count(verdict) for verdict in Verdict},
            "friction_left": float(left[stood].mean()) if stood.any() else float("nan"),
        }

    def tables(self) -> Sequence[Table]:
        """A row for each structure; the friction left is the mean of what stands."""
        return [self._table]

    def layers(self) -> Scene:
        """The first structure."""
        return bare_scene(self.model)

    def numbers(self) -> Mapping[str, Any]:
        """Numbers of structures, orders and subsets, and the folder."""
        return {
            "folder": str(self.folder), "orders": len(self.orders), "subsets": self.rows,
            "complete": not self.stopped,
        }  # fmt: skip

    def card(self) -> str:
        """What is in the data set, and how it is read, as Markdown."""
        heads, rows = self._table.cells()
        lines = [heads, ["---"] * len(heads), *rows]
        table = "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines)
        end = f"Not complete: {self.stopped}.\n\n" if self.stopped else ""
        card = shipped("sequence/dataset.md")
        return card.format(title=self.title, end=end, table=table, version=version(),
                           options=self.options, shard=SHARD)  # fmt: skip


class _Task(NamedTuple):
    """Orders of a structure that are answered together."""

    number: int
    model: Model
    options: DatasetOptions
    planned: bool
    orders: list[Stages]


@checked_call
def dataset(
    models: Iterable[Given],
    out: PathLike,
    *,
    options: DatasetOptions | None = None,
    **how: Unpack[LongHow],
) -> Dataset:
    """Write a data set of subsets of structures, their verdicts, the friction left, and orders.

    The data do not depend on the workers, nor on interruptions: an order that was being written
    when the process was killed is dropped, with a warning, and computed again.

    Parameters
    ----------
    models
        Complete structures: models, assemblies or files.
    out
        A folder, which is made; or that of the same call, which goes on there.
    options

    Raises
    ------
    InputError
        There is no structure, one cannot be made into a model, or nothing of it is fixed.
    FormatError
        The folder has other data, is damaged before its end, or cannot be written.
    """
    chosen = DatasetOptions.of(options)
    clock = Clock.of(how)
    given = _models(models, how)
    names = [_name(number, one) for number, one in enumerate(given)]
    tasks = [task for number, model in enumerate(given) for task in _tasks(number, model, chosen)]
    total = sum(len(task.orders) for task in tasks)
    folder = as_path(out)
    shards = _Shards(folder, _about(given, chosen, total), given)
    _require_asked(shards, tasks)
    _write_structures(folder, dict(zip(names, given, strict=True)))
    left = _left(tasks, len(shards.found))
    with WorkerPool(clock.workers) as pool:
        answers = pool.answers(_answered, [task for _, task in left], clock.late)
        for (known, _), records in zip(left, answers, strict=False):
            shards.add(records[known:])
            clock.tell("orders", len(shards.found), total)
    made = len(shards.found)
    stopped = f"{clock.reason} after {made} of {total} orders" if made < total else ""
    found = Dataset(
        folder, tuple(names), tuple(given), tuple(shards.found), options=chosen, stopped=stopped
    )
    write_text(folder / "README.md", found.card())
    return found


def read_dataset(folder: PathLike) -> Dataset:
    """The data set in a folder, as far as it was written.

    Parameters
    ----------
    folder
        Where :func:`dataset` wrote it.

    Raises
    ------
    FormatError
        There is none, or it is damaged, or its structures are not those of its orders.
    """
    place = as_path(folder)
    files = sorted((place / "structures").glob("*.json"))
    first = place / "orders" / _shard(0)
    if not files or not first.exists():
        raise FormatError("has no data set", where=str(folder), remedy="name the folder of one")
    about = Journal.about(first)
    try:
        kept = dict(about["options"])
        options = DatasetOptions(**{**kept, "each_s": float(kept["each_s"])})
        total = int(about["orders"])
    except (LookupError, TypeError, ValueError, OverflowError) as error:
        raise FormatError(
            "does not say what was asked of a data set", where=str(first),
            remedy="make the data set anew",
        ) from error  # fmt: skip
    structures = tuple(supported_model(file) for file in files)
    shards = _Shards(place, about | {"structures": _digest(structures)}, structures)
    made = len(shards.found)
    stopped = f"{made} of {total} orders" if made < total else ""
    names = tuple(file.stem for file in files)
    return Dataset(place, names, structures, tuple(shards.found), options=options, stopped=stopped)


class _Shards(OneLine):
    """The records of a folder, in files of so many."""

    def __init__(self, folder: Path, about: Mapping[str, Any], models: Sequence[Model]) -> None:
        self.folder, self.about = folder / "orders", about
        self.read = partial(_read, [len(one) for one in models])
        self.found: list[BuiltOrder] = []
        self.journal = self._next()
        while len(self.journal.records) == SHARD:
            self.journal = self._next()
        later = self.folder / _shard(len(self.found) // SHARD + 1)
        if later.exists():
            raise FormatError(
                f"there is '{later.name}', and only {len(self.journal.records)} records before it",
                where=str(self.journal.path), remedy="remove the later files to go on",
            )  # fmt: skip

    def _next(self) -> Journal:
        journal = Journal(self.folder / _shard(len(self.found) // SHARD), self.about, self.read)
        self.found += journal.records
        return journal

    def add(self, records: Sequence[dict[str, Any]]) -> None:
        """Write records, and begin another file where one is full."""
        while records:
            room = SHARD - len(self.found) % SHARD
            self.journal.add(records[:room])
            self.found += map(self.read, records[:room])
            if len(records) >= room:
                self.journal = self._next()
            records = records[room:]


def _shard(number: int) -> str:
    return f"{number:05}.journal"


def _about(models: Sequence[Model], options: DatasetOptions, orders: int) -> dict[str, Any]:
    """What the records depend on."""
    kept = {name: getattr(options, name) for name in DatasetOptions.__dataclass_fields__}
    kept["each_s"] = str(options.each_s)
    made = {"format": "drystone-dataset", "version": version()}
    return {**made, "structures": _digest(models), "options": kept, "orders": orders}


def _digest(models: Sequence[Model]) -> str:
    told = "".join(fingerprint(StagedModel(model)) for model in models)
    return hashlib.sha256(told.encode()).hexdigest()


def _models(models: Iterable[Given], how: How) -> list[Model]:
    """The structures as models."""
    if isinstance(models, str | bytes) or not isinstance(models, Iterable):
        raise InputError("the structures are no list", remedy="give a list, such as [model]")
    given = [supported_model(one, **how) for one in models]
    if not given:
        raise InputError("there is no structure", remedy="give one or more models")
    return given


def _name(number: int, model: Model) -> str:
    return f"{number:04}-{Path(model.origin.file).stem or 'structure'}"


def _write_structures(folder: Path, models: Mapping[str, Model]) -> None:
    """Make the folders, and write the structures, in place of files that may be damaged."""
    for part in ("structures", "orders"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    for name, model in models.items():
        write(model, folder / "structures" / f"{name}.json")


def _require_asked(shards: _Shards, tasks: Sequence[_Task]) -> None:
    """Refuse records of other orders than those that are asked for, as where a line was removed."""
    asked = [(task, drawn) for task in tasks for drawn in task.orders]
    for number, one in enumerate(shards.found):
        if number >= len(asked) or not _is_of(one, *asked[number]):
            raise FormatError(
                f"record {number} is of another order than was asked for",
                where=str(shards.folder / _shard(number // SHARD)),
                remedy="remove this file and later ones to make their orders anew",
            )


def _is_of(one: BuiltOrder, task: _Task, drawn: Stages) -> bool:
    """Whether an order is the one that was drawn, or may be that of the planner."""
    if one.structure != task.number or one.planned > task.planned:
        return False
    steps = zip(map(list, one.order), map(list, one.held), strict=True)
    return one.planned or [*steps] == drawn


def _left(tasks: Sequence[_Task], done: int) -> list[tuple[int, _Task]]:
    """Tasks that are not answered whole, each after so many of its orders that are known."""
    left = []
    for task in tasks:
        if done < len(task.orders):
            left.append((done, task))
        done = max(0, done - len(task.orders))
    return left


def _tasks(number: int, model: Model, options: DatasetOptions) -> Iterator[_Task]:
    """The orders of a structure, a few at a time."""
    staged, rows, drawn = StagedModel(model), 0, 0
    if not staged.everything:
        raise InputError("every block is a support", remedy="leave some free")
    if not staged.everything & ~staged.floating(staged.everything):
        raise InputError(
            "no free block is joined to a support",
            where=model.origin.file or f"structure {number}",
            remedy="fix blocks that carry others, or widen the gap within which faces touch",
        )
    if options.planned:
        yield _Task(number, model, options, True, [_drawn(staged, options, number, 0)])
    while rows < options.rows:
        orders, until = list[Stages](), min(rows + TOGETHER, options.rows)
        while rows < until:
            drawn += 1
            orders.append(_drawn(staged, options, number, drawn))
            rows += len(orders[-1])
        yield _Task(number, model, options, False, orders)


def _drawn(staged: StagedModel, options: DatasetOptions, number: int, walk: int) -> Stages:
    """A random order."""
    draw = np.random.default_rng([options.seed, number, walk])
    from_top = sorted(members(staged.everything), key=lambda b: -staged.height[b])
    placed, out = staged.everything & ~staged.floating(staged.everything), Stages()
    while placed:
        held = []
        if draw.random() < options.held:
            held = [int(draw.choice(list(members(placed))))]
        there = [block for block in from_top if placed >> block & 1][: options.width]
        left = placed & ~(1 << int(draw.choice(there)))
        left &= ~staged.floating(left)
        out.append(([*members(placed & ~left)], held))
        placed = left
    return out[::-1]


def _answered(task: _Task) -> list[dict[str, Any]]:
    """The records of orders, whose stages are asked from the largest on."""
    options = task.options
    structure = Structure(task.model, robust=options.robust, each_s=options.each_s)
    records = []
    for drawn in task.orders:
        planned = _planned(task.model) if task.planned else None
        order, helds = zip(*(drawn if planned is None else planned), strict=True)
        masks = _in_place(order, task.model)
        largest_first = zip(masks[::-1], helds[::-1], strict=True)
        answers = [structure.stands(mask, held=held) for mask, held in largest_first][::-1]
        records.append(
            {
                "structure": task.number,
                "planned": planned is not None,
                "order": list(order),
                "held": list(helds),
                "verdict": [one.verdict.value for one in answers],
                "friction_left": [
                    None if one.verdict is Verdict.UNDECIDED else round(one.friction_left, 6)
                    for one in answers
                ],
                "falling": [list(one.falling) for one in answers],
            }
        )
    return records


def _planned(model: Model) -> Stages | None:
    """The order of the planner, with its props; None where it has none."""
    found = plan(model)
    if not found.steps:
        return None
    return [([*map(int, step.blocks)], [*map(int, step.props)]) for step in found.steps]


def _in_place(order: Sequence[Sequence[int]], model: Model) -> Bools:
    """The blocks in place (s, n) after each step of an order, and the supports."""
    out = np.zeros((len(order), len(model)), dtype=bool)
    for step, blocks in enumerate(order):
        out[step:, list(blocks)] = True
    return out | model.assembly.fixed


def _read(sizes: Sequence[int], record: Any) -> BuiltOrder:
    """An order from its record, of structures with so many blocks."""
    several = [tuple(tuple(map(int, one)) for one in record[key]) for key in ("order", "held")]
    falling = tuple(tuple(map(int, one)) for one in record["falling"])
    verdict = tuple(map(Verdict, record["verdict"]))
    left = [float("nan") if one is None else float(one) for one in record["friction_left"]]
    if len({len(one) for one in (*several, verdict, left, falling)}) > 1:
        raise LookupError("its parts have several lengths")
    blocks = {block for one in (*several[0], *several[1], *falling) for block in one}
    if record["structure"] not in range(len(sizes)) or blocks - {
        *range(sizes[record["structure"]])
    }:
        raise LookupError("it has other blocks")
    return BuiltOrder(
        int(record["structure"]), bool(record["planned"]), several[0], several[1], verdict,
        frozen(np.array(left)), falling,
    )  # fmt: skip


def _stages(one: BuiltOrder) -> Iterator[tuple[int, int]]:
    """Blocks in place and held blocks after each step, as bits."""
    placed = 0
    for blocks, held in zip(one.order, one.held, strict=True):
        placed |= mask_of(blocks)
        yield placed, mask_of(held)
