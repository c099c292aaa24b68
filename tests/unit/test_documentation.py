"""What the README and the pages under docs say is so: their commands, examples, links, lists."""

import contextlib
import csv
import importlib
import inspect
import pkgutil
import re
import runpy
import shlex
import sys
import tomllib
from pathlib import Path

import click
import pytest
import yaml

import drystone as drystone_package
from drystone import Verdict, __version__, models
from drystone.cli import main
from drystone.cli.application import app
from tests.unit.cli.running import commands

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
"""Whose commands are parsed; ``docs/site/test_pages.py`` runs them."""
SETUP = "python3 -m venv .venv && .venv/bin/pip install . && .venv/bin/drystone demo"
TESTING = 'python3 -m venv .venv && .venv/bin/pip install ".[test]" && .venv/bin/pytest'


def test_the_two_commands_that_set_it_up_are_in_the_readme_and_the_second_is_what_ci_runs() -> None:
    assert len(README.splitlines()) < 120
    assert f"\n    {SETUP}\n" in README
    assert f"\n    {TESTING}\n" in README
    for command in (SETUP, TESTING):
        windows = command.replace("python3", "py").replace(".venv/bin/", ".venv\\Scripts\\")
        assert f"    {windows}\n" in README
    assert f"\n{TESTING}" in (ROOT / ".ci" / "run").read_text("utf-8")


def test_the_workflow_tests_every_python_as_the_readme_says_on_each_system() -> None:
    workflow = yaml.safe_load((ROOT / ".github/workflows/test.yml").read_text("utf-8"))
    jobs = workflow["jobs"]
    matrix = jobs["platforms"]["strategy"]["matrix"]
    assert matrix["system"] == ["ubuntu-latest", "macos-latest", "windows-latest"]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    told = [one.rpartition(" ")[2] for one in project["classifiers"] if "Python :: 3." in one]
    assert matrix["python"] == told
    assert project["requires-python"] == f">={told[0]}"
    run = {step.get("if"): step.get("run") for step in jobs["platforms"]["steps"]}
    windows = TESTING.replace("python3", "python").replace(".venv/bin/", ".venv\\Scripts\\")
    assert run["runner.os != 'Windows'"] == TESTING
    assert run["runner.os == 'Windows'"] == windows
    assert any(step.get("run") == ".ci/run" for step in jobs["all-checks"]["steps"])


@pytest.mark.parametrize(
    "path", [*(ROOT / ".github/workflows").glob("*.yml")], ids=lambda p: p.stem
)
def test_workflows_may_only_read_and_use_actions_of_one_commit(path: Path) -> None:
    workflow = yaml.safe_load(path.read_text("utf-8"))
    assert workflow["permissions"] == {"contents": "read"}
    jobs = workflow["jobs"]
    assert {name for name, job in jobs.items() if "permissions" in job} <= {"publish"}
    used = re.findall(r"uses: (.*)", path.read_text("utf-8"))
    assert [one for one in used if not re.fullmatch(r"\S+@[0-9a-f]{40} # v\d[\d.]*", one)] == []


def test_bad_input_is_one_line_and_exit_code_two(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["check", "absent.obj", "--html", "page.html"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (said,) = err.splitlines()
    assert "absent.obj" in said
    assert list(tmp_path.iterdir()) == []


OF_THE_PROJECT = ("docs", "examples", "integrations", "benchmarks", "src", "tests")
EVERY_MARKDOWN = sorted(
    [*ROOT.glob("*.md"), *(page for name in OF_THE_PROJECT for page in (ROOT / name).rglob("*.md"))]
)


def places(page: Path) -> set[str]:
    """Where a link with # may lead to in a page: its headings, as hosts of Markdown name them."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^#+ +(.*?) *$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in headings}


def links_of(page: Path) -> list[str]:
    """What the links and pictures of a page lead to, outside its code."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    return re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", text))


@pytest.mark.parametrize("page", EVERY_MARKDOWN, ids=lambda page: page.name)
def test_links_lead_to_a_file_and_to_a_place_in_it(page: Path) -> None:
    lost = []
    for link in links_of(page):
        name, _, place = link.partition("#")
        target = page.parent / name if name else page
        if link.startswith("https://"):
            if not re.match(r"https://([a-z0-9-]+\.)+[a-z]{2,}(/|$)", link):
                lost.append(link)
        elif not target.exists() or (place and place not in places(target)):
            lost.append(link)
    assert lost == []


def test_the_check_of_the_sites_links_finds_a_lost_page_a_lost_place_and_a_bad_address(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    check = runpy.run_path(str(ROOT / "docs" / "site" / "check_links.py"))["main"]
    (tmp_path / "a.html").write_text('<a href="b.html#here">b</a><a href="https://x.org/">x</a>')
    (tmp_path / "b.html").write_text('<p id="here"></p><a href="#top">up</a>')
    monkeypatch.setattr(sys, "argv", ["check_links", str(tmp_path), "--external"])
    assert check() == 0
    assert capsys.readouterr().out == "https://x.org/\n2 pages, 3 links, 1 other sites, 0 broken\n"
    shown = '<meta property="og:image" content="vault.png"><a href="c.html">c</a>'
    (tmp_path / "b.html").write_text(f'{shown}<a href="http://x.org">x</a>')
    assert check() == 1
    printed = capsys.readouterr().out
    assert "a.html: b.html#here: no such place in the page" in printed
    assert "b.html: c.html: no such file" in printed
    assert "http://x.org: not https" in printed
    assert "b.html: vault.png: others load this picture" in printed


def test_every_figure_of_the_source_has_its_row_and_the_examples_of_the_rows_exist() -> None:
    page = (ROOT / "docs" / "trust" / "tables" / "figures.csv").read_text("utf-8")
    rows = list(csv.reader(page.splitlines()))
    assert {len(row) for row in rows} == {3}
    numbers = {one.strip() for row in rows[1:] for one in row[0].split(",")} - {"none"}
    last = {"4": 3, "5": 4, "6": 21, "7": 17, "8": 2}
    figures = {f"{part}.{i}" for part, many in last.items() for i in range(1, many + 1)}
    assert numbers == figures | {"table 6.1", "table 6.2", "table 6.3", "table 6.4", "table 8.1"}
    examples = re.findall(r"\{doc\}`[^<]*</gallery/([^>]*plot[^>]*)>`", page)
    assert examples
    lost = [e for e in examples if not (ROOT / "examples" / "gallery" / f"{e}.py").exists()]
    assert lost == []


def test_the_commands_for_the_shelf_name_the_two_pieces_that_fall(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (ROOT / "docs" / "trust" / "tables" / "figures.csv").read_text("utf-8")
    (what,) = (row[2] for row in csv.reader(page.splitlines()) if row[0] == "6.12")
    for line in re.findall(r"`drystone ([^`]*FILE[^`]*)`", what):
        main([str(tmp_path / "shelf.json") if word == "FILE" else word for word in line.split()])
    assert "help is needed at block-9, block-10" in capsys.readouterr().out


def commands_of(page: Path) -> list[str]:
    """The command lines of a page, and in its text the commands that name a file."""
    text = page.read_text("utf-8").replace("\\\n", " ")
    lines = re.findall(r"^(?: {4}|\$ )(?:\S+/bin/)?drystone (.*?)(?: +# .*)?$", text, re.MULTILINE)
    named = r"`drystone ([a-z][^`\n]*\b(?:FILE|MODEL|SURFACE|FAMILY|\w+\.\w+)\b[^`\n]*)`"
    return [*lines, *re.findall(named, text)]


@pytest.mark.parametrize(
    "page", [page for page in PAGES if commands_of(page)], ids=lambda page: page.name
)
def test_the_commands_of_a_page_have_arguments_and_options_that_exist(page: Path) -> None:
    """They are parsed, not run."""
    for line in commands_of(page):
        arguments, command = shlex.split(line), app
        while isinstance(command, click.Group) and arguments:
            command = command_of(command, arguments.pop(0))
        with contextlib.suppress(click.exceptions.Exit), command.make_context(line, arguments):
            pass


def command_of(group: click.Group, name: str) -> click.Command:
    """The command of a name; it fails where there is none."""
    found = group.get_command(click.Context(group), name)
    assert found is not None, name
    return found


def test_every_command_answers_a_question() -> None:
    page = (ROOT / "docs" / "how-to" / "which-command.md").read_text("utf-8")
    names = commands()
    assert "limit tilt" in names
    assert [name for name in names if not re.search(rf"`drystone {name}[ `]", page)] == []


def test_every_dependency_has_its_line_and_every_line_its_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = project["optional-dependencies"]
    needed = {
        re.match(r"[\w.-]+", requirement)[0]  # type: ignore[index]
        for group in (project["dependencies"], *extras.values())
        for requirement in group
        if not requirement.startswith("drystone[")
    }
    page = (ROOT / "docs" / "developers" / "dependencies.md").read_text("utf-8")
    assert set(re.findall(r"^\| ([a-z][\w.-]*) \| [A-Z]", page, re.MULTILINE)) == needed


def test_the_front_page_shows_a_film_that_is_quick_to_load() -> None:
    film = ROOT / "docs" / "images" / "film.mp4"
    assert film.read_bytes()[4:8] == b"ftyp"
    assert film.stat().st_size < 3_000_000
    page = (ROOT / "docs" / "index.md").read_text("utf-8")
    assert f'src="_static/{film.name}"' in page
    assert f"images/{film.name}" in (ROOT / "docs" / "conf.py").read_text("utf-8")


def test_the_version_has_one_source() -> None:
    others = ["pyproject.toml", "benchmarks/field/pyproject.toml", "README.md"]
    others += ["docs/trust/citing.md", "docs/conf.py"]
    named = [name for name in others if __version__ in (ROOT / name).read_text("utf-8")]
    assert named == []
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert citation["version"] == citation["preferred-citation"]["version"] == __version__


def test_a_release_is_refused_until_its_addresses_date_and_version_are_there(
    tmp_path: Path,
) -> None:
    missing = runpy.run_path(str(ROOT / ".ci" / "check_release.py"))["missing"]
    assert "python .ci/check_release.py" in (ROOT / ".github/workflows/release.yml").read_text()
    names = ("Repository", "Issues", "Documentation", "Changelog")
    urls = "".join(f'{name} = "https://host.org/{name}"\n' for name in names)
    for name, text in {
        "pyproject.toml": f"[project.urls]\n{urls}",
        "CITATION.cff": 'repository-code: "https://host.org/drystone"\n',
        "CHANGELOG.md": "## 1.2.3 (2027-01-31)\n",
        "src/drystone/__init__.py": '__version__ = "1.2.3"\n',
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, "utf-8")
    assert missing(tmp_path, "v1.2.3") == []
    assert missing(tmp_path, "v1.2.4") == ["the tag is v1.2.4, the version is 1.2.3"]
    (tmp_path / "CHANGELOG.md").write_text("## 1.2.3 (not released)\n", "utf-8")
    (tmp_path / "CITATION.cff").write_text("title: drystone\n", "utf-8")
    (tmp_path / "pyproject.toml").write_text('[project.urls]\nIssues = "to be told"\n', "utf-8")
    assert len(missing(tmp_path)) == 6


def test_every_dependency_of_the_core_is_imported() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    source = "".join(path.read_text("utf-8") for path in (ROOT / "src").rglob("*.py"))
    needed = {re.match(r"\w+", requirement)[0] for requirement in project["dependencies"]}  # type: ignore[index]
    assert {name for name in needed if not re.search(rf"(import|from) {name}\b", source)} == set()


def test_an_extra_that_an_error_names_exists() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    named = {
        extra
        for path in (ROOT / "src").rglob("*.py")
        for extra in re.findall(r'extra="(\w+)"', path.read_text("utf-8"))
    }
    assert named
    assert named <= set(project["optional-dependencies"])


WITH_AN_EXTRA = {"drystone.cli", "drystone.gym", "drystone.mcp"}
"""The first is a program; the others need packages that the site is built without."""


def test_the_reference_has_every_public_name() -> None:
    reference = runpy.run_path(str(ROOT / "docs" / "site" / "reference.py"))
    seen: set[int] = set()
    listed = [m for modules in reference["ROOMS"].values() for m in modules]
    assert all(reference["public"](module, seen) for module in listed)
    modules = [f"drystone.{one.name}" for one in pkgutil.iter_modules(drystone_package.__path__)]
    assert {m: reference["public"](m, seen) for m in modules if m not in WITH_AN_EXTRA} == {
        m: [] for m in modules if m not in WITH_AN_EXTRA
    }


def test_the_reference_says_of_each_parameter_of_a_public_function_what_it_is() -> None:
    """In words, by its shape and unit, or by a link to its class."""
    reference = runpy.run_path(str(ROOT / "docs" / "site" / "reference.py"))
    seen: set[int] = set()
    silent = []
    for module in (one for modules in reference["ROOMS"].values() for one in modules):
        for name in reference["public"](module, seen):
            value = getattr(importlib.import_module(module), name)
            if not inspect.isfunction(value):
                continue
            lines = (inspect.getdoc(value) or "").splitlines()
            entries = reference["described"](value, lines) if "Parameters" in lines else {}
            said = {
                one
                for names, (head, *words) in entries.items()
                for one in names
                if words or " : " in head
            }
            silent += [
                f"{module}.{name}: {one}"
                for one in inspect.signature(value).parameters
                if one not in said
            ]
    assert silent == []


def test_the_page_of_models_has_every_family() -> None:
    page = (ROOT / "docs" / "reference" / "models.md").read_text("utf-8")
    assert [name for name in models.__all__ if f"`{name}`" not in page] == []


def test_the_pictures_of_the_readme_are_what_the_example_draws(tmp_path: Path) -> None:
    """Their verdicts and their names; pixels depend on the fonts of a machine."""
    example = runpy.run_path(str(ROOT / "examples" / "pictures.py"))
    standing, falling = example["main"](tmp_path)
    assert (standing.verdict, falling.verdict) == (Verdict.STABLE, Verdict.UNSTABLE)
    assert falling.falling_names == ("block-9", "block-10")
    for picture in tmp_path.iterdir():
        assert f"](docs/images/{picture.name})" in README
        assert (ROOT / "docs" / "images" / picture.name).read_bytes().startswith(b"\x89PNG")
    assert len(list(tmp_path.iterdir())) == 2


def test_the_moving_pictures_of_the_readme_are_what_the_example_draws(tmp_path: Path) -> None:
    from PIL import Image

    pytest.importorskip("mujoco")
    runpy.run_path(str(ROOT / "examples" / "moving_pictures.py"))["main"](tmp_path, 2)
    assert {path.name for path in tmp_path.iterdir()} == {"fall.gif", "plan.gif"}
    for made in tmp_path.iterdir():
        assert f"](docs/images/{made.name})" in README
        with Image.open(made) as drawn, Image.open(ROOT / "docs" / "images" / made.name) as shown:
            assert drawn.n_frames == 2
            assert shown.n_frames >= 8
            assert shown.size == drawn.size


def test_every_example_is_run_by_a_test() -> None:
    paths = [*(ROOT / "tests").rglob("*.py"), ROOT / "docs" / "site" / "test_pages.py"]
    tests = "".join(path.read_text("utf-8") for path in paths)
    names = {path.stem for path in (ROOT / "examples").glob("*.py")}
    assert names
    assert [name for name in names if not re.search(rf'"{name}(\.py)?"', tests)] == []


def test_the_drawings_show_the_layers_that_are_enforced_and_every_one_of_them() -> None:
    drawn = runpy.run_path(str(ROOT / "examples" / "diagrams.py"))
    assert drawn["house"]() == (ROOT / "docs" / "images" / "house.svg").read_text("utf-8")
    assert drawn["signs"]() == (ROOT / "docs" / "images" / "signs.svg").read_text("utf-8")
    assert {name for floor in drawn["FLOORS"].values() for name in floor} >= set(drawn["layers"]())


def test_the_figures_of_the_concepts_are_what_the_example_draws(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Their text; what is computed may differ by a pixel elsewhere. Each section has one."""
    monkeypatch.syspath_prepend(ROOT / "examples")
    drawings = runpy.run_path(str(ROOT / "examples" / "concept_figures.py"))["DRAWINGS"]
    page = (ROOT / "docs" / "concepts" / "concepts.md").read_text("utf-8")
    for name, draw in drawings.items():
        shown = (ROOT / "docs" / "images" / f"concept-{name}.svg").read_text("utf-8")
        assert re.findall(r">([^<]+)</text>", draw()) == re.findall(r">([^<]+)</text>", shown)
        assert f"](../images/concept-{name}.svg)" in page
    for section in page.split("\n## ")[1:]:
        assert "](../images/" in section or section.startswith(("Model\n", "Sources\n")), section


def test_a_picture_of_a_tutorial_is_what_the_example_draws(tmp_path: Path) -> None:
    """One of them; the answers of the others are compared where their commands are run."""
    from PIL import Image

    example = runpy.run_path(str(ROOT / "examples" / "tutorial_pictures.py"))
    assert sorted(example["DRAWN"]) == [
        "architect",
        "bridge",
        "church-wall",
        "engineer",
        "researcher",
        "retaining-wall",
        "roboticist",
        "vault",
    ]
    drawn = tmp_path / "tutorial-engineer.png"
    example["draw"]("engineer", example["DRAWN"]["engineer"], drawn)
    with Image.open(drawn) as now, Image.open(ROOT / "docs" / "images" / drawn.name) as shown:
        assert now.text["told"] == shown.text.get("told")
        assert now.size == shown.size
