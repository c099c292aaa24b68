"""Build hook: the package carries the commit that it was made from."""

import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CommitHook(BuildHookInterface[Any]):
    """Adds ``drystone/_commit.txt`` to what is built from a git checkout."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Ask git; a source distribution brings the file along."""
        root = Path(self.root)
        if version == "editable" or not (root / ".git").exists():
            return
        try:
            said = subprocess.run(
                ["git", "-C", self.root, "rev-parse", "--short=10", "HEAD"],
                capture_output=True, check=True, text=True, timeout=30.0,
            )  # fmt: skip
        except (OSError, subprocess.SubprocessError):
            return
        folder = Path(tempfile.mkdtemp(prefix="drystone-build-"))
        (folder / "_commit.txt").write_text(said.stdout, encoding="ascii")
        inside = "drystone" if self.target_name == "wheel" else "src/drystone"
        build_data["force_include"][str(folder / "_commit.txt")] = f"{inside}/_commit.txt"
