"""What of COMPAS the converters use, so that they are tested where COMPAS is not installed.

The parity tests run the same converters on the real packages.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from drystone import Assembly, Block, Contacts


class Mesh:
    """A mesh."""

    def __init__(self, block: Block, **attributes: Any) -> None:
        self.attributes = attributes
        self._data = (block.vertices.tolist(), [list(face) for face in block.faces])

    def to_vertices_and_faces(self) -> tuple[list[list[float]], list[list[int]]]:
        return self._data

    def face_vertices(self, face: int) -> list[int]:
        return self._data[1][face]


class Frame:
    """Origin and axes."""

    def __init__(self, point: Any, xaxis: Any, yaxis: Any) -> None:
        self.point, self.xaxis, self.yaxis = point, xaxis, yaxis


class Interface:
    """A polygon between two blocks."""

    def __init__(self, points: Any, frame: Frame, size: float = 0.0) -> None:
        self.points, self.frame, self.size = points, frame, size
        self.forces: list[dict[str, float]] | None = None


class Graph:
    """Nodes, and edges in one direction."""

    def __init__(self) -> None:
        self.node: dict[Any, dict[str, Any]] = {}
        self.edge: dict[tuple[Any, Any], dict[str, Any]] = {}

    def nodes(self) -> Iterator[Any]:
        return iter(self.node)

    def edges(self) -> Iterator[tuple[Any, Any]]:
        return iter(self.edge)

    def node_attribute(self, node: Any, name: str, value: Any = None) -> Any:
        if value is not None:
            self.node[node][name] = value
        return self.node[node].get(name)

    def edge_attribute(self, edge: tuple[Any, Any], name: str) -> Any:
        return self.edge[edge].get(name)


class CRAAssembly:
    """An assembly of compas_cra."""

    def __init__(self, assembly: Assembly, contacts: Contacts | None = None) -> None:
        self.graph = Graph()
        for i, (block, fixed) in enumerate(
            zip(assembly.blocks, assembly.fixed.tolist(), strict=True)
        ):
            self.graph.node[i] = {"block": Mesh(block), "is_support": fixed}
        for i in range(contacts.count if contacts is not None else 0):
            assert contacts is not None
            _, u, v = contacts.frame[i].tolist()
            frame = Frame(contacts.centroid[i].tolist(), u, v)
            a, b = int(contacts.block_a[i]), int(contacts.block_b[i])
            self.add_to_interfaces(a, b, 1.0, contacts.polygon(i).tolist(), frame)

    def node_block(self, node: Any) -> Mesh:
        mesh = self.graph.node[node]["block"]
        assert isinstance(mesh, Mesh)
        return mesh

    def add_to_interfaces(self, u: Any, v: Any, size: float, points: Any, frame: Frame) -> None:
        edge = self.graph.edge.setdefault((u, v), {"interfaces": []})
        edge["interfaces"].append(Interface(points, frame, size))

    def interfaces(self) -> list[Interface]:
        return [i for edge in self.graph.edge.values() for i in edge["interfaces"]]


class Material:
    """Something of a density."""

    def __init__(self, density: float) -> None:
        self.density = density


class Element:
    """A block of a model."""

    def __init__(
        self, geometry: Any, name: str, is_support: bool = False, density: float | None = None
    ) -> None:
        self.modelgeometry, self.name, self.is_support = geometry, name, is_support
        self.material = None if density is None else Material(density)


class ModelGraph(Graph):
    """Nodes that stand for elements."""

    def node_element(self, node: Any) -> Element:
        element = self.node[node]["element"]
        assert isinstance(element, Element)
        return element


class BlockModel:
    """A model of compas_dem."""

    def __init__(self, *elements: Element) -> None:
        self.graph = ModelGraph()
        for i, element in enumerate(elements):
            self.graph.node[i] = {"element": element}

    def elements(self) -> list[Element]:
        return [node["element"] for node in self.graph.node.values()]
