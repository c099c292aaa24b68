"""The conda recipe and the container file ask for what pyproject.toml says."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import yaml

import drystone

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
OTHER_NAMES = {"matplotlib": "matplotlib-base"}
"""Packages that conda-forge has by another name."""


def test_the_conda_recipe_asks_for_the_packages_of_the_project() -> None:
    recipe = yaml.safe_load((ROOT / "integrations" / "conda" / "recipe.yaml").read_text("utf-8"))
    asked = [f"python {PROJECT['requires-python']}"]
    for one in PROJECT["dependencies"]:
        name, bound = re.fullmatch(r"([\w-]+)(>=.+)", one).groups()  # type: ignore[union-attr]
        asked.append(f"{OTHER_NAMES.get(name, name)} {bound}")
    assert recipe["requirements"]["run"] == asked
    assert recipe["context"]["version"] == drystone.__version__
    (command,) = PROJECT["scripts"].items()
    assert recipe["build"]["python"]["entry_points"] == [" = ".join(command)]


def test_the_container_copies_what_a_build_needs_and_runs_a_python_that_is_supported() -> None:
    text = (ROOT / "integrations" / "container" / "Containerfile").read_text("utf-8")
    (python,) = re.findall(r"^FROM python:([\d.]+)-slim$", text, re.MULTILINE)
    assert f"Programming Language :: Python :: {python}" in PROJECT["classifiers"]
    copied = re.findall(r"[\w./]+(?=.* /src/)", " ".join(re.findall(r"^COPY (.*)", text, re.M)))
    assert {"pyproject.toml", "hatch_build.py", PROJECT["readme"], "src"} <= set(copied)
    assert set(PROJECT["license-files"]) <= set(copied)
    assert all((ROOT / name).exists() for name in copied if not name.startswith("/"))


def test_binder_installs_this_checkout_with_extras_that_exist() -> None:
    (line,) = (ROOT / ".binder" / "requirements.txt").read_text("utf-8").splitlines()
    extras = re.fullmatch(r"\.\[([\w,]+)\]", line)
    assert extras is not None
    assert set(extras[1].split(",")) <= set(PROJECT["optional-dependencies"])
    python = (ROOT / ".binder" / "runtime.txt").read_text("utf-8").strip().removeprefix("python-")
    assert f"Programming Language :: Python :: {python}" in PROJECT["classifiers"]
