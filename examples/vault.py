"""A barrel vault of wedged voussoirs: does it stand, and what does the mason need to know?

python examples/vault.py
"""

from pathlib import Path

from drystone.results import Result
from drystone.shells import (
    Layout,
    ShellBody,
    barrel_vault,
    build_shell,
    schedule,
    write_unrolled,
)
from drystone.stability import check
from drystone.view import save_page


def main(folder: Path = Path()) -> Result:
    """Build, check, and write the page, the schedule and the flattened joint faces."""
    shape = barrel_vault(span=5.0, length=4.0, rise=2.0)
    layout = Layout(courses=11, blocks=4, wedge=0.2)
    shell = build_shell(shape, layout, ShellBody(thickness=0.35))
    result = check(shell.model(friction=0.6))
    save_page(result, folder / "vault.html")
    schedule(shell).to_csv(folder / "vault.csv")
    write_unrolled(shell, folder / "vault.svg")
    print(
        f"{len(shell.voussoirs)} voussoirs, {result.contacts.count} joints: {result.verdict.value}"
    )
    return result


if __name__ == "__main__":
    main()
