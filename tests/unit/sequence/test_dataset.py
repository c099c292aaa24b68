"""Data sets of subsets: what a check says of each, whoever computes them, ended or not."""

import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from drystone import Assembly, FormatError, InputError, JointCapacity, Model, Verdict, check, write
from drystone.cli import main
from drystone.models import arch, box, tower
from drystone.sequence import DatasetOptions, dataset, read_dataset

ARCH = Model.of(arch(0.3, 5), friction=0.7)
SOME = DatasetOptions(rows=60, held=0.3)


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    dataset([ARCH, tower(4)], folder, options=SOME)
    return folder


def test_each_subset_has_the_verdict_of_a_check_and_belongs_to_an_order(whole):
    data = read_dataset(whole)
    assert not data.stopped
    assert data.rows >= 2 * SOME.rows
    assert {one.structure for one in data.orders} == {0, 1}
    held = 0
    for one in data.orders[:8]:
        model = data.structures[one.structure]
        masks = one.masks(model)
        assert masks[-1].all()
        assert (np.diff(masks.astype(int), axis=0) >= 0).all()
        for mask, hold, verdict in zip(masks, one.held, one.verdict, strict=True):
            fixed = [*np.flatnonzero(model.assembly.fixed), *hold]
            part = model.with_supports(fixed).subset(np.flatnonzero(mask))
            assert check(part).verdict is verdict
            held += len(hold)
        stands = np.array([each is Verdict.STABLE for each in one.verdict])
        assert (one.friction_left[~stands] == 0.0).all()
        assert not any(fell for fell, up in zip(one.falling, stands, strict=True) if up)
    assert held > 0


def test_the_card_says_what_is_in_it_and_its_code_reads_it(whole, capsys):
    card = (whole / "README.md").read_text("utf-8")
    data = read_dataset(whole)
    assert card.startswith(f"# {data.rows} subsets of 2 structures\n")
    assert "rows=60, held=0.3" in card
    for row in data.table():
        assert (
            f"| {row['structure']} | {row['blocks']} | {row['orders']} | {row['subsets']} |" in card
        )
        assert row["stable"] + row["unstable"] + row["undecided"] == row["subsets"]
    (code,) = re.findall(r"^```python\n(.*?)^```$", card, re.M | re.S)
    exec(code.replace("FOLDER", whole.as_posix()), {})
    assert capsys.readouterr().out.count("\n") >= len(data.orders)


def test_workers_change_nothing(whole, tmp_path):
    with ThreadPoolExecutor(2) as workers:
        dataset([ARCH, tower(4)], tmp_path, options=SOME, executor=workers)
    assert content(tmp_path) == content(whole)


@pytest.mark.parametrize("cut", [0, 1, 20])
def test_it_goes_on_where_it_ended_and_a_torn_last_record_is_dropped(whole, tmp_path, caplog, cut):
    asked = [0]

    def stop() -> bool:
        asked[0] += 1
        return asked[0] > 1

    begun = dataset([ARCH, tower(4)], tmp_path, options=SOME, stop=stop)
    first = sum(not one.structure for one in read_dataset(whole).orders)
    assert begun.stopped.startswith(f"it was interrupted after {first} of ")
    assert "Not complete: it was interrupted" in (tmp_path / "README.md").read_text("utf-8")
    assert read_dataset(tmp_path).rows == begun.rows
    file = tmp_path / "orders" / "00000.journal"
    data = file.read_bytes()
    file.write_bytes(data[: len(data) - cut])
    dataset([ARCH, tower(4)], tmp_path, options=SOME)
    assert ("the last record is cut off" in caplog.text) == (cut > 0)
    assert content(tmp_path) == content(whole)


def test_damage_before_the_end_is_told_in_one_line(tmp_path, capsys):
    write(ARCH, tmp_path / "arch.json")
    asked = ["dataset", str(tmp_path / "arch.json"), "--out", str(tmp_path / "data"), "--rows", "9"]
    assert main(asked) == 0
    assert "subsets of 1 structure" in capsys.readouterr().out
    file = tmp_path / "data" / "orders" / "00000.journal"
    text = file.read_bytes()
    file.write_bytes(text.replace(b"stable", b"stabel", 1))
    assert main(asked) == 2
    told = capsys.readouterr()
    assert (told.out, told.err.count("\n")) == ("", 1)
    assert "line 2 of" in told.err
    file.write_bytes(text)
    assert main([*asked[:-1], "10"]) == 2
    assert "is of other work: options" in capsys.readouterr().err


def test_many_orders_are_in_several_files(tmp_path):
    options = DatasetOptions(rows=515)
    found = dataset([tower(2)], tmp_path, options=options)
    files = sorted((tmp_path / "orders").iterdir())
    assert [one.name for one in files] == ["00000.journal", "00001.journal"]
    assert [len(one.read_bytes().splitlines()) - 1 for one in files] == [
        512,
        len(found.orders) - 512,
    ]
    files[0].write_bytes(b"".join(files[0].read_bytes().splitlines(keepends=True)[:-1]))
    with pytest.raises(FormatError, match="and only 511 records before it"):
        dataset([tower(2)], tmp_path, options=options)


def test_the_first_order_may_be_that_of_the_planner(tmp_path):
    found = dataset([ARCH], tmp_path, options=DatasetOptions(rows=1, planned=True))
    first, second = found.orders[:2]
    assert (first.planned, second.planned) == (True, False)
    assert {*first.verdict} == {Verdict.STABLE}
    assert any(first.held)  # a prop


def test_what_cannot_be_asked_is_refused(tmp_path):
    fixed = ARCH.with_supports(range(len(ARCH)))
    apart = Model.of(
        Assembly((box((1, 1, 1), (0, 0, 0), "a"), box((1, 1, 1), (5, 0, 5), "b"))).with_fixed([0])
    )
    for given, words in (
        ([], "no structure"),
        ("a.json", "give a list of models"),
        ([fixed], "is a support"),
        ([apart], "no free block is joined to a support"),
    ):
        with pytest.raises(InputError, match=words):
            dataset(given, tmp_path)
    with pytest.raises(InputError, match="held is 2"):
        DatasetOptions(held=2.0)
    with pytest.raises(FormatError, match="has no data set"):
        read_dataset(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_data_set_of_joints_with_another_capacity_is_not_continued(tmp_path):
    stack = Model.of(tower(2))
    few = DatasetOptions(rows=4)
    dataset([stack], tmp_path, options=few)
    glued = stack.with_capacity(JointCapacity.of(stack.contacts, tension=1700.0))
    with pytest.raises(FormatError, match="is of other work: structures"):
        dataset([glued], tmp_path, options=few)
