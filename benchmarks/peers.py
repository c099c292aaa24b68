"""Contact search of other packages: run by their own Python, on a wall in a JSON file.

``python peers.py PACKAGE WALL.json`` prints one JSON object: version, contacts, seconds of CPU.
Nothing of drystone is imported here.
"""

import json
import sys
import time
from importlib.metadata import version
from pathlib import Path

AREA = 1e-4
"""[m2] Smallest contact asked for; their defaults are larger than the joints of the wall."""


def compas_cra(blocks):
    from compas_assembly.datastructures import Block
    from compas_cra.algorithms import assembly_interfaces_numpy
    from compas_cra.datastructures import CRA_Assembly

    assembly = CRA_Assembly()
    for block in blocks:
        assembly.add_block(Block.from_vertices_and_faces(block["vertices"], block["faces"]))
    begin = time.process_time()
    assembly_interfaces_numpy(assembly, nmax=10, tmax=1e-6, amin=AREA)
    seconds = time.process_time() - begin
    return sum(
        len(assembly.graph.edge_attribute(e, "interfaces")) for e in assembly.edges()
    ), seconds


def compas_dem(blocks):
    from compas.datastructures import Mesh
    from compas_dem.models import BlockModel

    model = BlockModel()
    for block in blocks:
        model.add_block_from_mesh(Mesh.from_vertices_and_faces(block["vertices"], block["faces"]))
    begin = time.process_time()
    model.compute_contacts(tolerance=1e-6, minimum_area=AREA)
    seconds = time.process_time() - begin
    return sum(1 for _ in model.contacts()), seconds


if __name__ == "__main__":
    package, path = sys.argv[1:]
    blocks = json.loads(Path(path).read_text(encoding="utf-8"))["blocks"]
    count, seconds = {"compas_cra": compas_cra, "compas_dem": compas_dem}[package](blocks)
    print(json.dumps({"version": version(package), "contacts": count, "seconds": seconds}))
