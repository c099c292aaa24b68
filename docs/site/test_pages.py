"""What the pages show is what their commands and their Python print; their notebooks run.

pytest docs/site

Apart from the other tests, as it runs much of the package once more.
"""

import contextlib
import doctest
import importlib
import re
import runpy
import shlex
import sys
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
from PIL import Image

from drystone import io, models
from drystone.cli import main
from tests.unit.cli.running import commands
from tests.unit.test_public_api import WITH_EXAMPLES

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TUTORIALS = [
    page.stem
    for page in sorted((ROOT / "docs" / "tutorials").glob("*.md"))
    if "\n$ drystone " in page.read_text("utf-8")
]


@pytest.fixture(autouse=True)
def _a_terminal_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables would depend on its size."""
    for size in ("COLUMNS", "LINES"):
        monkeypatch.delenv(size, raising=False)


def python_blocks(page: Path) -> list[str]:
    """The Python examples of a page, in order."""
    return re.findall(r"^```python\n(.*?)^```$", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder of someone who ran the README's Python example, and what it printed."""
    folder = tmp_path_factory.mktemp("readme")
    (example,) = python_blocks(ROOT / "README.md")
    printed = StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(printed):
        exec(compile(example, "README.md", "exec"), {"__name__": "page"})
    return folder, printed.getvalue()


def test_the_readmes_example_is_a_dozen_lines_and_prints_what_stands_below_it(
    followed: tuple[Path, str],
) -> None:
    """And it writes a page and a picture."""
    (example,) = python_blocks(ROOT / "README.md")
    assert sum(bool(line.strip()) for line in example.splitlines()) <= 12
    folder, printed = followed
    shown = "".join(f"    {line}\n" for line in printed.splitlines())
    assert f"{example}```\n\n{shown}" in README
    assert (folder / "vault.html").read_text("utf-8").startswith("<!doctype html>")
    assert (folder / "vault.png").read_bytes().startswith(b"\x89PNG")


ANSWERS = {
    "check vault.obj --supports lowest --friction": (0, "STABLE"),
    "check vault.obj --supports lowest --gravity": (1, "no contact forces can balance the loads"),
    "inspect vault.obj": (0, "97 blocks"),
    "inspect vault.obj --supports lowest --json": (0, '"contacts": '),
    "shell barrel": (0, "STABLE"),
    "limit friction barrel.json": (0, "stands at"),
    "plan barrel.json": (1, "1 propped"),
    "convert vault.obj": (0, "wrote vault.glb"),
}
"""Beginning of each command of the README: its exit code, and words of its answer."""


def test_the_readmes_commands_answer_as_it_says(
    followed: tuple[Path, str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """In their order: some read what an earlier one wrote."""
    folder, _ = followed
    monkeypatch.chdir(folder)
    commands = re.findall(r"^ {4}drystone (.*)$", README, re.MULTILINE)
    assert len(commands) == len(ANSWERS)
    for command, (beginning, (code, words)) in zip(commands, ANSWERS.items(), strict=True):
        assert command.startswith(beginning)
        answered = main(shlex.split(command))
        printed = capsys.readouterr()
        assert (answered, printed.err) == (code, ""), command
        assert words in printed.out, command
    written = {path.name for path in folder.iterdir()}
    assert {"fall.png", "barrel.json", "plan.html", "vault.glb"} <= written


@pytest.mark.parametrize(
    "page",
    [
        page
        for page in [ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
        if python_blocks(page) and page.stem not in TUTORIALS
    ],
    ids=lambda page: page.name,
)
def test_the_python_of_a_page_runs(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its blocks one after another, as a reader would, in an empty folder.

    A block that says in its first line that it needs something is read only.
    """
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "page"}
    for block in python_blocks(page):
        if block.startswith("# needs "):
            compile(block, page.name, "exec")
            continue
        exec(compile(block, page.name, "exec"), names)


@pytest.mark.parametrize("name", TUTORIALS)
def test_a_tutorial_shows_what_its_commands_and_its_code_print(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Line by line and in their order; three dots stand for lines that are not shown.

    The picture of the page keeps the words of the answer that it shows: they are printed as well.
    """
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "tutorials" / f"{name}.md").read_text("utf-8")
    told, names, shown, every = "", {"__name__": "page"}, 0, ""
    for kind, block in re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        if kind == "python":
            exec(compile(block, name, "exec"), names)
            told = capsys.readouterr().out
        elif kind == "text":
            assert block == told
            shown += 1
        for part in re.split(r"^\$ drystone ", block, flags=re.MULTILINE)[1:]:
            command, *lines = part.splitlines()
            assert main(shlex.split(command)) in (0, 1), command
            told = capsys.readouterr().out
            every += told
            printed = (line.rstrip() for line in told.splitlines())
            missing = [one for one in lines if one != "..." and one not in printed]
            assert missing == [], f"{command} prints:\n{told}"
            shown += bool(lines)
    assert shown >= 3
    assert f"](../images/tutorial-{name}.png)" in text
    with Image.open(ROOT / "docs" / "images" / f"tutorial-{name}.png") as picture:
        missing = [one for one in picture.text["told"].splitlines() if one not in every]
        assert missing == [], f"the picture is older than its answer, which is:\n{every}"


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_examples_in_docstrings_are_true(module: str) -> None:
    """The reference shows them."""
    if module.startswith("drystone.gym"):
        pytest.importorskip("gymnasium")
    result = doctest.testmod(importlib.import_module(module), verbose=False)
    assert result.attempted > 0
    assert result.failed == 0


LEFT_OUT = {"demo", "reproduce", "mcp", "live"} | (set() if find_spec("mujoco") else {"fall"})


@pytest.mark.parametrize("name", sorted(commands().keys() - LEFT_OUT))
def test_the_examples_of_a_command_run(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside their files. 'reproduce' takes long, 'mcp' and 'live' wait, 'demo' has a test."""
    monkeypatch.chdir(tmp_path)
    io.write(models.arch(voussoirs=7), "arch.json")
    cases = 'situations = ["STR"]\n[case.gravity]\nkind = "permanent"\n'
    Path("cases.toml").write_text(cases, encoding="utf-8")
    examples = commands()[name].examples
    for example in examples:
        if any(other.startswith(f"{example} ") for other in examples):
            continue  # the other one does the same, and more
        program, *given = shlex.split(example)
        assert program == "drystone"
        assert main(given) in (0, 1), example
        assert capsys.readouterr().err == ""
        named = [word for word in given if re.search(r"\.(html|png|csv|obj|json)$", word)]
        assert all(Path(word).exists() for word in named), example


@pytest.mark.filterwarnings("ignore")
def test_the_jupyter_notebook_runs_and_shows_pages(tmp_path: Path) -> None:
    """As a user runs it."""
    nbformat = pytest.importorskip("nbformat", reason="no nbformat (Jupyter)")
    nbclient = pytest.importorskip("nbclient", reason="no nbclient (Jupyter)")
    pytest.importorskip("ipykernel", reason="no ipykernel (Jupyter)")
    pytest.importorskip("anywidget", reason="no anywidget, the extra 'notebook'")
    content = nbformat.read(ROOT / "examples" / "notebook.ipynb", as_version=4)
    where: dict[str, Any] = {"metadata": {"path": str(tmp_path)}}
    done = nbclient.NotebookClient(content, timeout=300, resources=where).execute()
    outputs = [cell.outputs for cell in done.cells if cell.cell_type == "code"]
    pages = [
        out.data["text/html"]
        for cell in outputs
        for out in cell
        if "text/html" in out.get("data", {})
    ]
    assert sum("<iframe" in page for page in pages) == 4  # model, result, limit, show
    assert any("anywidget" in str(out) or "widget-view" in str(out) for out in outputs)
    assert "UNSTABLE" in str(outputs[-1])
    assert sum(map(len, pages)) < 1_000_000


@pytest.mark.filterwarnings("ignore")
def test_the_marimo_notebook_runs() -> None:
    """As a user runs it."""
    pytest.importorskip("marimo", reason="no marimo")
    pytest.importorskip("anywidget", reason="no anywidget, the extra 'notebook'")
    app = runpy.run_path(str(ROOT / "examples" / "notebook_marimo.py"))["app"]
    _, found = app.run()
    assert found["result"].stable
    assert found["told"] == "click a block"


@pytest.mark.parametrize(
    ("repository", "site"), [("", ""), ("OWNER/NAME", "https://owner.github.io/NAME/")]
)
def test_buttons_and_the_social_picture_have_the_address_of_the_repository_or_are_not_there(
    repository: str, site: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A repository of a local build has none."""
    pytest.importorskip("sphinx_gallery", reason="no Sphinx, the extra 'docs'")
    monkeypatch.setenv("GITHUB_REPOSITORY", repository)
    monkeypatch.delenv("DRYSTONE_SITE", raising=False)
    monkeypatch.setattr("sys.path", sys.path[:])
    conf = runpy.run_path(str(ROOT / "docs" / "conf.py"))
    context: dict[str, str] = {"title": "A page"}
    conf["social"](None, "index", "page.html", context)
    pictures = re.findall('property="og:image" content="(.*?)"', context["metatags"])
    told = conf["myst_substitutions"]["buttons"]
    opened = re.findall(r"\]\((.*?)\)", told)
    assert conf["html_baseurl"] == site
    assert pictures == ([f"{site}_static/vault.png"] if site else [])
    assert len(opened) == (2 if site else 0)
    assert all(f"/{repository}/" in one for one in opened)
    assert all("examples/notebook.ipynb" in unquote(one) for one in opened)
    assert bool(site) == (f"git+https://github.com/{repository}`" in told)
    lines = [
        f'<span class="go">{one}</span>\n' for one in ("moved:", " a  b", "...", " 1  2", "...")
    ]
    conf["rows_stay"](None, "index", "page.html", context := {"body": "".join(lines)})
    table = "".join(lines[1:4]).rstrip()  # with what is left out between its rows
    assert f'{lines[0]}<span class="rows">{table}</span>\n{lines[4]}' == context["body"]
