"""One model, many files: the same contacts and the same verdict."""

from pathlib import Path

import numpy as np
import pytest

from drystone import Assembly, Contacts, Model, check, find_contacts, io
from drystone.models import arch, concave, vault

EXACT = ("drystone", "compas-assembly", "compas-dem", "obj", "stl", "ply")
SUFFIX = {"obj": ".obj", "stl": ".stl", "ply": ".ply", "glb": ".glb"}


def through(assembly: Assembly, name: str, folder: Path) -> Assembly:
    path = folder / f"model{SUFFIX.get(name, '.json')}"
    io.write(assembly, path, format=name)
    return Assembly(io.read_file(path).assembly.blocks, assembly.fixed)


def interfaces(contacts: Contacts) -> list[tuple[int, int, float]]:
    pairs = zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
    return sorted((a, b, area) for (a, b), area in zip(pairs, contacts.area.tolist(), strict=True))


@pytest.mark.parametrize("assembly", [arch(), concave("short"), vault(courses=7, blocks=3)])
@pytest.mark.parametrize("name", [*EXACT, "glb"])
def test_every_format_gives_the_same_contacts(
    tmp_path: Path, name: str, assembly: Assembly
) -> None:
    expected = interfaces(find_contacts(assembly).contacts)
    found = interfaces(find_contacts(through(assembly, name, tmp_path)).contacts)
    assert [pair[:2] for pair in found] == [pair[:2] for pair in expected]
    tolerance = 1e-12 if name in EXACT else 1e-5
    areas, wanted = np.array([p[2] for p in found]), np.array([p[2] for p in expected])
    assert areas == pytest.approx(wanted, rel=tolerance, abs=tolerance)


@pytest.mark.parametrize("name", ["compas-dem", "stl", "glb"])
@pytest.mark.parametrize("friction", [0.15, 0.6])
def test_every_format_gives_the_same_verdict(tmp_path: Path, name: str, friction: float) -> None:
    one, other = arch(voussoirs=12), through(arch(voussoirs=12), name, tmp_path)
    verdicts = [check(Model.of(a, friction=friction)).verdict for a in (one, other)]
    assert verdicts[0] is verdicts[1]
