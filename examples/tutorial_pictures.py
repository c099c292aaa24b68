"""The pictures of the tutorials, drawn by the commands of their pages.

python examples/tutorial_pictures.py docs/images
"""

import contextlib
import io
import json
import re
import shlex
import sys
import tempfile
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from drystone.cli import main as answer

PAGES = Path(__file__).parents[1] / "docs" / "tutorials"
DRAWN = {
    "architect": "check",
    "bridge": "limit train",
    "church-wall": 'kinematic chapel.json --direction -y --part "facade-*" '
    "--tie facade-4@3,0.3,4.5:apse@3,6.3,4.5:20kN",
    "engineer": "check",
    "researcher": "check",
    "retaining-wall": "check",
    "roboticist": "plan",
    "vault": "settle",
}
"""The first command of each page that begins so is drawn."""
BY_PYTHON = {"bridge": "worst.png"}
"""What the Python of a page draws of it in place of the command."""
STEP = re.compile(r"^\$ drystone ([^\n]+)$|^```python\n(.+?)^```$", re.MULTILINE | re.DOTALL)
COLOURS = 256
WIDTH = 900
"""Pixels."""


def draw(page: str, command: str, target: Path) -> None:
    """Do the steps of a page up to the command that is drawn, and draw it."""
    text = (PAGES / f"{page}.md").read_text("utf-8")
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        drawn, about = Path(BY_PYTHON.get(page, "drawn.png")), PngInfo()
        for line, code in (one.groups() for one in STEP.finditer(text)):
            said, wanted = io.StringIO(), bool(line) and line.startswith(command)
            more = ["--json", *([] if page in BY_PYTHON else ["--png", drawn.name])]
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(io.StringIO()):
                if code:
                    exec(compile(code, page, "exec"), {})
                else:
                    words = shlex.split(line)
                    if wanted and "--png" in words:  # the page names its own
                        at = words.index("--png")
                        del words[at : at + 2]
                    answer([*words, *(more if wanted else [])])
            if wanted:
                sentences = json.loads(said.getvalue())["sentences"]
                about.add_text("told", "\n".join(sentences[:4]))
            if drawn.exists():
                break
        with Image.open(drawn) as image:
            small = image.convert("RGB").resize((WIDTH, WIDTH * image.height // image.width))
            small.quantize(COLOURS, Image.Quantize.FASTOCTREE).save(
                target, pnginfo=about, optimize=True
            )


def main(folder: Path = Path()) -> None:
    """Draw the picture of each page."""
    target = folder.resolve()
    for page, command in DRAWN.items():
        draw(page, command, target / f"tutorial-{page}.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
