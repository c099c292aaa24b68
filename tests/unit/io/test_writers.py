"""Every file is written by one of two writers: whole and renamed, or record by record."""

import ast
import re
from pathlib import Path

import pytest

import drystone

PACKAGE = Path(drystone.__file__).parent
WRITERS = {"base/files.py", "base/journal.py"}
OTHERS = {
    ("cli/output.py", "open"): "the null device, in place of a closed stream",
    ("io/extract.py", "fdopen"): "a pipe to the process that started it",
    ("io/usd_extract.py", "TemporaryDirectory"): "read by USD, in a process without drystone",
    ("io/usd_extract.py", "write_bytes"): "the same",
    ("live/tasks.py", "TemporaryDirectory"): "read again at once, by the one writer",
    ("mcp/folder.py", "TemporaryDirectory"): "the same",
    ("view/notebook.py", "NamedTemporaryFile"): "a name for a page that the browser opens",
    ("view/notebook.py", "TemporaryDirectory"): "read again at once, by the one writer",
    ("report/report_pdf.py", "save"): "into memory",
    ("report/sketches.py", "savefig"): "into memory",
    ("sequence/dataset.py", "mkdir"): "folders, in which the one writer writes",
    ("view/gif.py", "save"): "into memory",
    ("view/gif.py", "savefig"): "into memory",
    ("view/plots.py", "savefig"): "into memory",
}
"""Other calls that write, and why they may."""
CALLS = {
    *("write_text", "write_bytes", "touch", "mkdir", "makedirs", "rename", "renames", "symlink_to"),
    *("hardlink_to", "copyfile", "copytree", "truncate", "fdopen", "mkstemp", "mkdtemp"),
    *("NamedTemporaryFile", "TemporaryFile", "TemporaryDirectory", "SpooledTemporaryFile"),
    *("memmap", "save", "savez", "savez_compressed", "savetxt", "tofile", "dump", "savefig"),
    *("imsave", "export", "saveas", "Export", "writestr"),
}
"""Methods and functions of modules that write, in whatever library."""
OF_MODULES = {"os.open", "shutil.copy", "shutil.copy2", "shutil.move", "sqlite3.connect"}
OPENING = {"open": 1, "ZipFile": 1, "TarFile": 1, "GzipFile": 1}
"""Functions with a mode, and its place; that of a method ``open`` comes one place before."""
NAMES = re.compile(
    rf"\b({'|'.join([*CALLS, *OPENING, *(one.partition('.')[2] for one in OF_MODULES)])})\("
)


def raw_writes(text: str) -> set[str]:
    """Names of the calls in a module that write a file, or could."""
    if not NAMES.search(text):  # most do not: parsing takes long
        return set()
    return {
        ast.unparse(node.func).rpartition(".")[2]
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call) and _writes(node)
    }


def _writes(call: ast.Call) -> bool:
    of = ast.unparse(call.func)
    before, _, name = of.rpartition(".")
    if of in OF_MODULES or (before and name in CALLS):
        return True
    if name not in OPENING:
        return False
    place = OPENING[name] - (name == "open" and before not in ("", "io", "gzip", "bz2", "lzma"))
    modes = [*call.args[place : place + 1], *(k.value for k in call.keywords if k.arg == "mode")]
    return any(isinstance(one, ast.Constant) and {*str(one.value)} & {*"wax+"} for one in modes)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("open('a', 'w')", "open"),
        ("Path('a').open(mode='xb')", "open"),
        ("os.open('a', 66)", "open"),
        ("path.write_text('a')", "write_text"),
        ("np.savez(path, a=a)", "savez"),
        ("json.dump(a, file)", "dump"),
        ("figure.savefig(path)", "savefig"),
        ("zipfile.ZipFile(path, 'w')", "ZipFile"),
        ("tempfile.mkdtemp()", "mkdtemp"),
    ],
)
def test_what_writes_is_seen(text: str, name: str) -> None:
    assert raw_writes(text) == {name}


def test_what_reads_is_not_taken_for_what_writes() -> None:
    text = "open('a'); p.open('rb'); zipfile.ZipFile(f); write_text(p, 'a'); json.dumps(a)"
    assert raw_writes(text) == set()


def test_every_file_is_written_by_the_one_writer_or_the_one_journal() -> None:
    found = {
        (path.relative_to(PACKAGE).as_posix(), name)
        for path in sorted(PACKAGE.rglob("*.py"))
        for name in raw_writes(path.read_text(encoding="utf-8"))
        if path.relative_to(PACKAGE).as_posix() not in WRITERS
    }
    assert found == set(OTHERS), "write with drystone.base.files, or say here why not"
