"""Three vaults on three feet: the form is found so that the thrust lies in the shell.

python examples/freeform.py
"""

from pathlib import Path

from drystone.results import Result
from drystone.shells import Layout, build_shell, find_form, schedule, three_legged_plan
from drystone.stability import check
from drystone.view import save_page


def main(folder: Path = Path()) -> Result:
    """Find the form, build, check, and write the page and the schedule."""
    form = find_form(three_legged_plan(reach=6.0, waist=2.5, foot=2.4), height=2.5, thickness=0.2)
    shell = build_shell(form.shape, Layout(courses=6, width=1.0, wedge=-0.1))
    result = check(shell.model(friction=0.6))
    save_page(result, folder / "freeform.html")
    schedule(shell).to_csv(folder / "freeform.csv")
    print(
        f"{len(shell.voussoirs)} voussoirs, {result.contacts.count} joints, largest warp "
        f"{shell.planar.warp_before:.1%} of a block made planar: {result.verdict.value}"
    )
    return result


if __name__ == "__main__":
    main()
