"""Is everything there that a release needs? Names what is missing and exits with 1; else with 0.

python .ci/check_release.py

The workflow *Release* runs this before it builds. The address of the project is told when there is
one; until then nothing is invented in its place.
"""

import os
import re
import sys
import tomllib
from pathlib import Path

URLS = ("Repository", "Issues", "Documentation", "Changelog")
"""Entries of ``[project.urls]`` that a release has, each with https."""
ADDRESS = re.compile(r"https://([a-z0-9-]+\.)+[a-z]{2,}/\S*")


def missing(root: Path, tag: str = "") -> list[str]:
    """What a release of the tree at ``root`` lacks; ``tag`` is its tag, if it has one."""
    found = []
    project = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]
    for name in URLS:
        address = project.get("urls", {}).get(name, "")
        if not ADDRESS.fullmatch(address):
            found.append(f"pyproject.toml: [project.urls] has no https address for {name}")
    citation = (root / "CITATION.cff").read_text("utf-8")
    code = re.search(r"^repository-code: *\"?([^\"\s]*)", citation, re.MULTILINE)
    if code is None or not ADDRESS.fullmatch(code[1]):
        found.append("CITATION.cff: no repository-code with an https address")
    source = (root / "src" / "drystone" / "__init__.py").read_text("utf-8")
    version = re.search(r'^__version__ = "(\d+\.\d+\.\d+)"$', source, re.MULTILINE)
    if version is None:
        return [*found, "src/drystone/__init__.py: __version__ is no version of a release"]
    changes = (root / "CHANGELOG.md").read_text("utf-8")
    if not re.search(rf"^## {re.escape(version[1])} \(\d{{4}}-\d\d-\d\d\)$", changes, re.MULTILINE):
        found.append(f"CHANGELOG.md: the heading of {version[1]} has no date")
    if tag and tag != f"v{version[1]}":
        found.append(f"the tag is {tag}, the version is {version[1]}")
    return found


def main() -> int:
    """Check the tree that this file is part of."""
    tagged = os.environ.get("GITHUB_REF_TYPE") == "tag"
    tag = os.environ.get("GITHUB_REF_NAME", "") if tagged else ""
    found = missing(Path(__file__).parents[1], tag)
    print("\n".join(found) if found else "nothing is missing")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
