"""Tables of results: comma-separated values beside the page that shows them."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from drystone.base.files import write_bytes

TABLES = Path(__file__).parents[1] / "docs" / "trust" / "tables"


def write_table(path: Path, lines: Sequence[str]) -> None:
    """Write the lines of a Markdown table; a table that is there is replaced as a whole."""
    text = io.StringIO()
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines]
    csv.writer(text, lineterminator="\n").writerows([rows[0], *rows[2:]])
    write_bytes(path, text.getvalue().encode())


def read_table(path: Path) -> list[dict[str, str]]:
    """The rows, by the heads of their columns."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write_part(page: Path, name: str, text: str) -> None:
    """Write what stands between the marks of this name in a page."""
    begin, end = f"<!-- {name} -->\n", f"<!-- end {name} -->"
    before, found, rest = page.read_text(encoding="utf-8").partition(begin)
    _, ended, after = rest.partition(end)
    if not (found and ended):
        raise SystemExit(f"{page} has no marks {begin.strip()} and {end}")
    write_bytes(page, f"{before}{begin}{text}\n{end}{after}".encode())
