"""What work keeps on disk survives what cuts or damages it: plans, searches, studies, data sets."""

import json
import logging
import os
import random
import sys
import zlib
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import drystone
from drystone.design import Parameter, TuneOptions, tune
from drystone.detection import DetectionOptions
from drystone.models import tower
from drystone.sequence import DatasetOptions, dataset, read_dataset
from drystone.studies import study


def planned(file: Path) -> object:
    found = drystone.plan(tower(3), checkpoint=file)
    return [(step.blocks, step.props, step.answer.verdict) for step in found.steps]


def tuned(file: Path) -> object:
    options = TuneOptions(trials=3, batch=2)
    found = tune(partial(tower, 2), [Parameter("edge", 0.5, 2.0)], store=file, options=options)
    return [(one.values, one.goals, one.stands) for one in found.trials]


def checked(file: Path) -> object:
    found = drystone.check_many([tower(1), tower(2), tower(3)], out=file, friction=0.6)
    return [found[name].tolist() for name in ("number", "verdict", "falling", "message")]


def studied(file: Path) -> object:
    found = study(tower, {"count": [2, 3, 4]}, out=file, friction=0.6)
    return [
        found[name].tolist() for name in ("number", "count", "verdict", "tilt_margin", "message")
    ]


def gathered(file: Path) -> object:
    options = DatasetOptions(rows=24)
    found = dataset([tower(3)], file.parent.parent, options=options, friction=0.6)
    return [(one.order, one.held, one.verdict, one.friction_left.tolist()) for one in found.orders]


WORK = pytest.mark.parametrize("work", [planned, tuned, checked, studied, gathered])


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Where a data set has its first records."""
    (tmp_path / "orders").mkdir()
    return tmp_path / "orders" / "00000.journal"


def again(work: Callable[[Path], object], file: Path, data: bytes) -> object:
    """The answer that goes on from a file, or why it does not."""
    file.write_bytes(data)
    try:
        return work(file)
    except drystone.InputError as error:
        return "refused" if str(file) in str(error) else str(error)


@WORK
def test_a_file_that_is_cut_anywhere_goes_on_to_the_same_answer(work, file, caplog) -> None:
    whole, data = work(file), file.read_bytes()
    assert work(file) == whole
    assert file.read_bytes().startswith(data)
    head = data.index(b"\n") + 1
    for cut in range(0, len(data), 100):
        found = again(work, file, data[:cut])
        assert found == ("refused" if 0 < cut < head else whole)
        torn = cut > head and data[cut - 1 : cut] != b"\n"
        assert torn == ("left out" in caplog.text)
        caplog.clear()


@WORK
def test_a_damaged_byte_never_gives_another_answer(work, file, caplog) -> None:
    caplog.set_level(logging.CRITICAL)
    whole, data = work(file), file.read_bytes()
    for place in range(0, len(data), 89):
        damaged = bytearray(data)
        damaged[place] ^= 1 << place % 8
        assert again(work, file, bytes(damaged)) in ("refused", whole)


@WORK
def test_a_record_of_other_values_is_refused_in_words_though_its_checksum_is_right(
    work, file, caplog
) -> None:
    caplog.set_level(logging.CRITICAL)
    work(file)
    head, first, *others = file.read_bytes().splitlines()
    record = json.loads(first.partition(b" ")[2])
    rng = random.Random(0)
    odd = (None, True, -1, 10**30, "x", [], {}, [[]], float("nan"), [1e308] * 3)
    keys = list(record) if isinstance(record, dict) else range(len(record))
    changed = [[record[key] for key in keys][:-1], *odd]
    for key in keys:
        for value in rng.sample(odd, 6):
            changed.append(record.copy())
            changed[-1][key] = value
    refused = 0
    for one in changed:
        text = json.dumps(one).encode()
        lines = [head, b"%08x %s" % (zlib.crc32(text), text), *others, b""]
        refused += again(work, file, b"\n".join(lines)) == "refused"
    assert refused > len(changed) / 2


def test_a_damaged_line_is_named_and_what_is_before_it_can_be_used(file) -> None:
    whole = checked(file)
    lines = file.read_bytes().splitlines(keepends=True)
    bad = [*lines[:2], lines[2].replace(b"stable", b"stab1e"), lines[3]]
    file.write_bytes(b"".join(bad))
    with pytest.raises(drystone.FormatError, match=r"line 3 of 4 is damaged.*the 1 records before"):
        checked(file)
    file.write_bytes(b"".join(lines[:2]))
    assert checked(file) == whole


def test_what_holds_zeros_only_is_told_to_be_removed_and_begins_anew_without(file) -> None:
    """As a power cut leaves it; no model has to be exported again."""
    file.write_bytes(bytes(300))
    with pytest.raises(drystone.DrystoneError, match=r"empty; .*remove this one to start anew"):
        planned(file)
    file.unlink()
    assert planned(file)


def test_a_data_set_that_does_not_say_what_was_asked_is_refused(file: Path) -> None:
    gathered(file)
    head, *records = file.read_bytes().splitlines(keepends=True)
    about = json.loads(head.partition(b" ")[2])
    odd = (
        None,
        [],
        {"each_s": "x"},
        {**about["options"], "rows": -1},
        {**about["options"], "x": 1},
    )
    for options in odd:
        text = json.dumps({**about, "options": options}).encode()
        file.write_bytes(b"".join([b"%08x %s\n" % (zlib.crc32(text), text), *records]))
        with pytest.raises(drystone.InputError):
            read_dataset(file.parent.parent)


def test_a_structure_of_a_data_set_that_was_changed_is_refused_and_written_anew(file: Path) -> None:
    """A digit that is damaged leaves a sound file of another structure."""
    folder = file.parent.parent
    whole = gathered(file)
    (structure,) = (folder / "structures").iterdir()
    sound = structure.read_bytes()
    structure.write_bytes(sound.replace(b"0.6", b"0.7"))
    with pytest.raises(drystone.FormatError, match="is of other work: structures differ"):
        read_dataset(folder)
    assert gathered(file) == whole
    assert structure.read_bytes() == sound
    assert len(read_dataset(folder).orders) == len(whole)  # type: ignore[arg-type]


@WORK
def test_lines_that_are_lost_doubled_or_out_of_order_never_give_another_answer(work, file) -> None:
    whole = work(file)
    head, first, *others = file.read_bytes().splitlines(keepends=True)
    for lines in (others, [first, first, *others], [*others[::-1], first], [first, *others, first]):
        assert again(work, file, b"".join([head, *lines])) in ("refused", whole)


@pytest.mark.parametrize("part", ["order", "held", "falling"])
@pytest.mark.parametrize("block", [-1, 3, 10**30])
def test_an_order_with_blocks_that_its_structure_has_not_is_refused(
    part: str, block: int, file: Path
) -> None:
    gathered(file)
    head, first, *others = file.read_bytes().splitlines()
    record = json.loads(first.partition(b" ")[2])
    record[part][0] = [block]
    text = json.dumps(record).encode()
    file.write_bytes(b"\n".join([head, b"%08x %s" % (zlib.crc32(text), text), *others, b""]))
    with pytest.raises(drystone.FormatError, match="is damaged: it is no such record"):
        gathered(file)


@WORK
def test_a_disk_that_is_full_is_told_with_the_file_and_spoils_nothing(work, file, tmp_path) -> None:
    resource = pytest.importorskip("resource", reason="Windows has no limit of the size of files")
    other = tmp_path / "other" / "orders" / file.name
    other.parent.mkdir(parents=True)
    whole = work(other)
    room = other.stat().st_size * 2 // 3
    before, silent = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode = True  # Python would keep cut bytecode of what is imported meanwhile
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
    try:
        with pytest.raises(drystone.FormatError, match=r"00000.*cannot be written"):
            work(file)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        sys.dont_write_bytecode = silent
    data = file.read_bytes()
    assert len(data) <= room
    assert data == b"" or data.endswith(b"\n")
    assert work(file) == whole


def test_answers_of_other_options_and_of_other_processes_are_not_mixed(file) -> None:
    checked(file)
    with pytest.raises(drystone.FormatError, match="is of other work: friction differ"):
        drystone.check_many([tower(1)], out=file, friction=0.5)

    def meddle(*_: object) -> bool:
        with file.open("ab") as other:
            other.write(os.urandom(4))
        return False

    file.unlink()
    with pytest.raises(drystone.FormatError, match="changed by another process"):
        drystone.check_many([tower(1), tower(2)], out=file, executor=None, progress=meddle)


def test_records_of_models_that_are_not_asked_about_are_not_answered(file: Path) -> None:
    models = [tower(count) for count in (1, 2, 3)]
    drystone.check_many(models, out=file, friction=0.6)
    assert len(drystone.check_many(models[:2], out=file, friction=0.6)) == 2
    with pytest.raises(drystone.InputError, match="model 0 '' has another content"):
        drystone.check_many(models[1:], out=file, friction=0.6, time_limit_s=0.0)
    file.unlink()
    studied(file)
    assert study(tower, {"count": [2, 3]}, out=file, friction=0.6)["count"].tolist() == [2, 3]


@WORK
def test_records_of_another_version_are_not_gone_on_from(work, file) -> None:
    work(file)
    head, *records = file.read_bytes().splitlines(keepends=True)
    about = json.loads(head.partition(b" ")[2])
    text = json.dumps({**about, "version": "0.0.1"}).encode()
    file.write_bytes(b"".join([b"%08x %s\n" % (zlib.crc32(text), text), *records]))
    with pytest.raises(drystone.FormatError, match=r"00000.*is of other work: version differ"):
        work(file)


@pytest.mark.parametrize("form", ["drystone", "compas-assembly"])
def test_a_stored_model_that_is_cut_or_damaged_is_read_or_refused_in_one_line(
    form: str, tmp_path
) -> None:
    drystone.io.write(drystone.check(tower(2)), tmp_path / "model.json", format=form)
    for file in sorted(tmp_path.iterdir()):
        data = file.read_bytes()
        cuts = [(data[:cut], True) for cut in range(0, len(data) - 2, 100)]
        for place in range(0, len(data), 89):
            damaged = bytearray(data)
            damaged[place] ^= 1 << place % 8
            cuts.append((bytes(damaged), False))
        for content, is_lost in cuts:
            file.write_bytes(content)
            said = ""
            try:
                drystone.read(tmp_path / "model.json")
            except drystone.InputError as error:
                said = str(error)
            assert file.name in said or (said == "" and not is_lost)
            assert "\n" not in said
        file.write_bytes(data)


def asked_twice(ask: Callable[[], object], change: Callable[[], object], file: Path) -> bool:
    """Whether work that something was changed of is refused, and goes on before."""
    ask()
    ask()
    change()
    try:
        ask()
    except drystone.InputError as error:
        return str(file) in str(error)
    return False


@pytest.mark.parametrize("work", ["checked", "studied", "varied", "tuned"])
def test_a_file_that_an_option_names_and_every_wrench_are_of_the_work(work: str, tmp_path) -> None:
    """Two load cases of one total are told alike; a table of capacities has the same name."""
    file, table, blocks = tmp_path / "kept", tmp_path / "joints.csv", tower(3)
    names = blocks.names
    load = [drystone.LoadCase.gravity(blocks)]

    def ask(name: str, given: object) -> object:
        if work == "checked":
            return drystone.check_many([blocks], out=file, **{name: given})
        if work == "varied":
            return study(blocks, {name: [given]}, out=file)
        if work == "studied":
            return study(blocks, {"friction": [0.6]}, out=file, **{name: given})
        options = TuneOptions(trials=1)
        edge = [Parameter("edge", 0.9, 1.1)]
        return tune(partial(tower, 3), edge, how={name: given}, store=file, options=options)

    def write(tension: float) -> None:
        lines = ["block_a,block_b,tension", f"{names[0]},{names[1]},{tension}"]
        table.write_text("\n".join([*lines, f"{names[1]},{names[2]},{tension}"]))

    def push(block: int) -> None:
        other = drystone.LoadCase.point_load(blocks, names[block], force=(1e5, 0.0, 0.0))
        load[0] = drystone.LoadCase.gravity(blocks) + other

    push(1)
    assert asked_twice(lambda: ask("load", load[0]), lambda: push(2), file)
    file.unlink()
    write(1e6)
    assert asked_twice(lambda: ask("joint_capacity", str(table)), lambda: write(0.0), file)
    file.unlink()
    write(1e6)
    asked = f"{table},ductile"
    assert asked_twice(lambda: ask("joint_capacity", asked), lambda: write(1.0), file)


def test_areas_of_joints_are_of_the_work(file: Path) -> None:
    given = [drystone.Model.of(tower(3), supports="lowest")]

    def halve() -> None:
        contacts = given[0].contacts
        given[0] = given[0].with_contacts(replace(contacts, area=contacts.area / 2.0))

    assert asked_twice(lambda: drystone.check_many(given, out=file), halve, file)


def test_meshes_that_a_scene_names_are_of_the_work(file: Path, tmp_path: Path) -> None:
    drystone.write(drystone.Model.of(tower(3)), tmp_path / "pile.urdf")
    mesh = sorted(tmp_path.rglob("*.obj"))[-1]

    def ask() -> object:
        return drystone.check_many([tmp_path / "pile.urdf"], out=file, supports="lowest")

    def grow() -> None:
        mesh.write_text(mesh.read_text().replace("v 0.5", "v 0.6"))

    assert asked_twice(ask, grow, file)


def test_load_cases_of_a_model_and_all_digits_of_options_are_of_the_work(file: Path) -> None:
    blocks = tower(3)
    push = drystone.LoadCase.point_load(blocks, blocks.names[2], force=(1e5, 0.0, 0.0))
    push = replace(push, name="push")
    asked = [0.001, 0.0050001]

    def of_cases() -> object:
        model = replace(drystone.Model.of(blocks, friction=0.6), cases=(asked[0] * push,))
        return drystone.check_many([model], out=file, case="push")

    def of_digits() -> object:
        options = DetectionOptions(gap=asked[1])
        return drystone.check_many([blocks], out=file, detection=options)

    assert asked_twice(of_cases, lambda: asked.__setitem__(0, 1.0), file)
    file.unlink()
    assert asked_twice(of_digits, lambda: asked.__setitem__(1, 0.00500014), file)
