import errno
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import pytest

import drystone
from drystone import FormatError, InputError, io
from drystone.base import files
from drystone.cli import main
from drystone.models import tower


@pytest.mark.parametrize(
    ("name", "make", "words"),
    [
        ("missing.obj", None, ["no such file", "check the path"]),
        ("empty.obj", lambda p: p.write_bytes(b""), ["empty"]),
        ("blank.json", lambda p: p.write_bytes(b" \r\n\t\n"), ["empty"]),
        ("zeros.json", lambda p: p.write_bytes(bytes(100)), ["empty"]),
        ("folder.obj", lambda p: p.mkdir(), ["folder"]),
        ("latin.obj", lambda p: p.write_bytes(b"o Gew\xf6lbe\n"), ["byte 5", "UTF-8"]),
        ("latin.json", lambda p: p.write_bytes(b'{"a": "\xf6"}'), ["byte 7", "UTF-8"]),
        (
            "packed.obj",
            lambda p: p.write_bytes(b"PK\x03\x04\x14"),
            ["packed.obj: is a zip", "unpack"],
        ),
        (
            "packed.stl",
            lambda p: p.write_bytes(b"PK\x03\x04\x14"),
            ["packed.stl: is a zip", "unpack"],
        ),
        ("binary.obj", lambda p: p.write_bytes(b"\x7fELF\0\xff"), ["is binary", "name it by its"]),
        ("wide.obj", lambda p: p.write_bytes("o Gewölbe".encode("utf-16")), ["byte 0", "UTF-8"]),
        ("model.doc", lambda p: p.write_bytes(b"x"), ["'.doc'", ".json", ".obj"]),
        ("model", lambda p: p.write_bytes(b"x"), ["no suffix"]),
        ("bad\0name.obj", None, ["bad"]),
        ("x" * 300 + ".obj", None, ["xxx"]),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(
    tmp_path: Path, name: str, make: Callable[[Path], object] | None, words: list[str]
) -> None:
    path = tmp_path / name
    if make is not None:
        make(path)
    with pytest.raises(FormatError) as caught:
        io.read_file(path)
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


def test_files_larger_than_allowed_are_not_opened(tmp_path: Path) -> None:
    path = tmp_path / "large.obj"
    with path.open("wb") as file:
        file.truncate(files.LARGEST_FILE + 1)
    with pytest.raises(FormatError, match=r"more than the 64 MiB allowed.*--max-size"):
        io.read_file(path)


def test_a_byte_order_mark_is_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "tower.obj"
    io.write(tower(2), path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert len(io.read_file(path).assembly) == 2


def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("old", encoding="utf-8")

    def interrupted(file: BinaryIO) -> None:
        file.write(b"half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        files.write_whole(path, interrupted)
    assert path.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_replaced_file_keeps_its_permissions(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("old", encoding="utf-8")
    path.chmod(0o640)
    files.write_bytes(path, b"new")
    assert path.read_bytes() == b"new"
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_new_file_gets_the_usual_permissions(tmp_path: Path) -> None:
    mask = os.umask(0o027)
    try:
        files.write_bytes(tmp_path / "a", b"")
    finally:
        os.umask(mask)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("name", ["none/model.obj", "model.doc", "model"])
def test_what_cannot_be_written_is_told_and_nothing_appears(tmp_path: Path, name: str) -> None:
    with pytest.raises(FormatError) as caught:
        io.write(tower(2), tmp_path / name)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_only_models_assemblies_and_results_are_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"model is .*; give Model\("):
        io.write([], tmp_path / "model.obj")  # type: ignore[arg-type]


def test_a_format_can_be_asked_for_by_name(tmp_path: Path) -> None:
    io.write(tower(2), tmp_path / "tower.txt", format="obj")
    assert (tmp_path / "tower.txt").read_text(encoding="utf-8").startswith("# drystone")
    with pytest.raises(FormatError, match="format 'dwg' is not known; use one of drystone"):
        io.write(tower(2), tmp_path / "tower.dwg", format="dwg")


def test_files_written_together_are_all_there_or_none(tmp_path: Path) -> None:
    one, other = tmp_path / "one.txt", tmp_path / "other.txt"
    one.write_text("old", encoding="utf-8")

    def fine(path: Path) -> None:
        assert (path.suffix, path.parent.parent) == (".txt", tmp_path)
        path.write_text("new", encoding="utf-8")

    def full(path: Path) -> None:
        path.write_text("half", encoding="utf-8")
        raise OSError("no space left")

    with pytest.raises(FormatError, match=r"other\.txt: cannot be written: no space left"):
        files.write_together([(one, fine), (other, full)])
    assert one.read_text(encoding="utf-8") == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["one.txt"]
    assert files.write_together([(one, fine), (other, fine)]) == [str(one), str(other)]
    assert one.read_text(encoding="utf-8") == other.read_text(encoding="utf-8") == "new"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.txt", "other.txt"]


@pytest.mark.parametrize("last", ["folder", "none/x.txt", "./one.txt"])
def test_together_nothing_is_written_where_one_name_is_bad(tmp_path: Path, last: str) -> None:
    (tmp_path / "folder").mkdir()
    one = tmp_path / "one.txt"
    with pytest.raises(FormatError):
        files.write_together([(one, Path.touch), (tmp_path / last, Path.touch)])
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


@pytest.mark.parametrize(
    ("number", "remedy"),
    [
        (errno.ENOSPC, "free some space, or choose"),
        (errno.EFBIG, "write to another disk, or raise"),
    ],
)
def test_a_full_disk_is_told_as_one(tmp_path: Path, number: int, remedy: str) -> None:
    def fill(_: BinaryIO) -> None:
        raise OSError(number, os.strerror(number))

    with pytest.raises(FormatError, match=f"{os.strerror(number)}; {remedy}"):
        files.write_whole(tmp_path / "a.csv", fill)
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_process_left_is_removed_by_the_next_that_writes(tmp_path: Path) -> None:
    left, young = tmp_path / ".drystone-1", tmp_path / ".drystone-2"
    (tmp_path / f".drystone-{files._machine()}-{'9' * 30}-x").mkdir()  # no process has this number
    for one in (left, young):
        one.mkdir()
        (one / "half.json").touch()
    os.utime(left, (1e9, 1e9))
    files.write_bytes(tmp_path / "a.csv", b"1")
    assert sorted(one.name for one in tmp_path.iterdir()) == [".drystone-2", "a.csv"]


@pytest.mark.skipif(not hasattr(os, "uname"), reason="ended processes are told apart on POSIX")
def test_what_a_process_left_that_was_killed_just_now_is_removed_too(tmp_path: Path) -> None:
    code = (
        "import os, sys\n"
        "from drystone.base.files import write_whole\n"
        "write_whole(sys.argv[1], lambda file: (file.write(b'half'), os.kill(os.getpid(), 9)))"
    )
    page = tmp_path / "page.html"
    assert subprocess.run([sys.executable, "-c", code, str(page)], check=False).returncode == -9
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".drystone-")
    other = []

    def while_it_works(file: BinaryIO) -> None:
        files.write_bytes(tmp_path / "a.csv", b"1")
        other.extend(one for one in tmp_path.iterdir() if one.is_dir())
        file.write(b"whole")

    files.write_whole(page, while_it_works)
    assert len(other) == 1
    assert left not in other
    assert sorted(one.name for one in tmp_path.iterdir()) == ["a.csv", "page.html"]


def test_a_model_of_several_files_is_written_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "tower.urdf"
    io.write(tower(2), target)
    before = {one: one.read_bytes() for one in tmp_path.rglob("*.*") if one.is_file()}
    written = files.write_whole

    def full(path: Path, fill: Callable[[BinaryIO], None]) -> None:
        if Path(path).name == target.name:
            raise OSError(errno.ENOSPC, "No space left on device")
        written(path, fill)

    monkeypatch.setattr(files, "write_whole", full)
    for there in (True, False):
        with pytest.raises(FormatError, match=r"tower.urdf: cannot be written: No space left"):
            io.write(tower(3), target)
        after = {one: one.read_bytes() for one in tmp_path.rglob("*.*") if one.is_file()}
        assert after == (before if there else {})
        shutil.rmtree(tmp_path)
        tmp_path.mkdir()
    assert list(tmp_path.iterdir()) == []


def test_a_name_may_be_as_long_as_the_disk_allows(tmp_path: Path) -> None:
    path = tmp_path / (251 * "a" + ".csv")
    files.write_bytes(path, b"1")
    assert path.read_bytes() == b"1"
    with pytest.raises(FormatError, match="File name too long; choose a shorter name"):
        files.write_bytes(tmp_path / (252 * "a" + ".csv"), b"1")


@pytest.mark.parametrize("name", ["a\0b", "a\ud800", 300 * "a"], ids=["null", "surrogate", "long"])
def test_what_no_file_can_be_called_is_refused_wherever_it_is_given(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    model, calls = tower(2), []
    calls += [lambda: drystone.check(name), lambda: drystone.read(name)]
    calls += [lambda: drystone.plan(model, checkpoint=name)]
    calls += [lambda: drystone.check_many([model], out=name)]
    for call in calls:
        with pytest.raises(InputError, match=r"no such file|is no name of a file|choose a shorter"):
            call()
    io.write(model, "tower.json")
    for command in (
        ["convert", "tower.json", f"{name}.json"],
        ["check", "tower.json", "--csv", f"{name}.csv"],
        ["study", name, "--set", "friction=0.4"],
    ):
        assert main(command) == 2
        assert "Errno" not in capsys.readouterr().err
    assert [one.name for one in tmp_path.iterdir()] == ["tower.json"]
