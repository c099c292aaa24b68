"""A dome with an eye, on springers that are fixed.

python examples/dome.py
"""

from pathlib import Path

from drystone.results import Result
from drystone.shells import Ground, Layout, ShellBody, build_shell, dome, schedule
from drystone.stability import check
from drystone.view import save_page


def main(folder: Path = Path()) -> Result:
    """Build, check, and write the page and the schedule."""
    shape = dome(radius=4.0, oculus=0.8)
    layout = Layout(courses=5, width=1.6)
    body = ShellBody(thickness=0.35, ground=Ground.SPRINGERS)
    shell = build_shell(shape, layout, body)
    result = check(shell.model(friction=0.6))
    save_page(result, folder / "dome.html")
    schedule(shell).to_csv(folder / "dome.csv")
    print(
        f"{len(shell.voussoirs)} voussoirs, {result.contacts.count} joints: {result.verdict.value}"
    )
    return result


if __name__ == "__main__":
    main()
