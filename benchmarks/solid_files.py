"""Small files of STEP and IFC, for tests and for damage: text made of a few blocks."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from drystone import Block
from drystone.geometry.frames import area_vector


class Entities:
    """Entities of ISO 10303-21, numbered as they are added."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, text: str) -> str:
        """Its number, as others name it."""
        self.lines.append(f"#{len(self.lines) + 1}={text};")
        return f"#{len(self.lines)}"

    def file(self, schema: str) -> str:
        """The whole file."""
        head = ["ISO-10303-21;", "HEADER;", "FILE_DESCRIPTION((''),'2;1');"]
        head += ["FILE_NAME('','',(''),(''),'','','');", f"FILE_SCHEMA(('{schema}'));", "ENDSEC;"]
        return "\n".join([*head, "DATA;", *self.lines, "ENDSEC;", "END-ISO-10303-21;", ""])


def step_file(blocks: Sequence[Block], unit: str = "$") -> str:
    """Faceted solids, each a product of its own."""
    out = Entities()
    app = out.add("APPLICATION_CONTEXT('design')")
    out.add(f"APPLICATION_PROTOCOL_DEFINITION('','automotive_design',2000,{app})")
    length = out.add(f"(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({unit},.METRE.))")
    angle = out.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid = out.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    near = out.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-7),{length},'d','')")
    context = out.add(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)"
        f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({near}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))REPRESENTATION_CONTEXT('',''))"
    )
    for block in blocks:
        at = [out.add("CARTESIAN_POINT('',({:f},{:f},{:f}))".format(*p)) for p in block.vertices]
        faces = []
        for loop in block.faces:
            ring = out.add(f"POLY_LOOP('',({','.join(at[i] for i in loop)}))")
            bound = out.add(f"FACE_OUTER_BOUND('',{ring},.T.)")
            corner = block.vertices[list(loop)]
            ways = [corner[1] - corner[0], area_vector(corner)]
            along, up = (out.add("DIRECTION('',({:f},{:f},{:f}))".format(*way)) for way in ways)
            axes = out.add(f"AXIS2_PLACEMENT_3D('',{at[loop[0]]},{up},{along})")
            plane = out.add(f"PLANE('',{axes})")
            faces.append(out.add(f"FACE_SURFACE('',({bound}),{plane},.T.)"))
        shell = out.add(f"CLOSED_SHELL('',({','.join(faces)}))")
        brep = out.add(f"FACETED_BREP('{block.name}',{shell})")
        shape = out.add(f"FACETED_BREP_SHAPE_REPRESENTATION('',({brep}),{context})")
        area = out.add(f"PRODUCT_CONTEXT('',{app},'mechanical')")
        product = out.add(f"PRODUCT('{block.name}','{block.name}','',({area}))")
        formation = out.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        view = out.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{app},'design')")
        definition = out.add(f"PRODUCT_DEFINITION('design','',{formation},{view})")
        of = out.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        out.add(f"SHAPE_DEFINITION_REPRESENTATION({of},{shape})")
    return out.file("AUTOMOTIVE_DESIGN")


def ifc_file(elements: Sequence[tuple[str, str, Block, str]], unit: str = "$") -> str:
    """Elements of a class, a name and a body; the last text is the name of the wall they are in."""
    out = Entities()
    point = out.add("IFCCARTESIANPOINT((0.,0.,0.))")
    axes = out.add(f"IFCAXIS2PLACEMENT3D({point},$,$)")
    place = out.add(f"IFCLOCALPLACEMENT($,{axes})")
    length = out.add(f"IFCSIUNIT(*,.LENGTHUNIT.,{unit},.METRE.)")
    units = out.add(f"IFCUNITASSIGNMENT(({length}))")
    context = out.add(f"IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-6,{axes},$)")
    out.add(f"IFCPROJECT('p',$,'p',$,$,$,$,({context}),{units})")
    walls: dict[str, tuple[str, list[str]]] = {}
    for number, (kind, name, block, wall) in enumerate(elements):
        corners = ",".join("({:f},{:f},{:f})".format(*at) for at in block.vertices)
        points = out.add(f"IFCCARTESIANPOINTLIST3D(({corners}))")
        loops = [
            out.add(f"IFCINDEXEDPOLYGONALFACE(({','.join(str(i + 1) for i in loop)}))")
            for loop in block.faces
        ]
        body = out.add(f"IFCPOLYGONALFACESET({points},.T.,({','.join(loops)}),$)")
        shape = out.add(f"IFCSHAPEREPRESENTATION({context},'Body','Tessellation',({body}))")
        of = out.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
        more = ",$" * {"IfcBuildingElementPart": 2, "IfcDoor": 6}.get(kind, 2)
        part = out.add(f"{kind.upper()}('e{number}',$,'{name}',$,$,{place},{of}{more})")
        if wall:
            known = walls.get(wall) or (
                out.add(f"IFCWALL('{wall}',$,'{wall}',$,$,{place},$,$,$)"),
                [],
            )
            walls[wall] = known
            known[1].append(part)
    for whole, parts in walls.values():
        out.add(f"IFCRELAGGREGATES('r{whole[1:]}',$,$,$,{whole},({','.join(parts)}))")
    return out.file("IFC4")


def wall_of_layers(
    layers: list[tuple[str, str, float]], sense: str = "POSITIVE", offset: float = 0.0
) -> tuple[Any, Any, Any, Any]:
    """A wall of 2 x 0.5 x 1 m at (1, 2, 0), turned by 0.5 rad, as ifcopenshell makes it in mm.

    Returns its file, the wall, its shape and the context. A layer has a material, its category and
    a thickness [m].
    """
    api = importlib.import_module("ifcopenshell.api")
    file = api.run("project.create_file", version="IFC4")
    api.run("root.create_entity", file, ifc_class="IfcProject", name="p")
    api.run("unit.assign_unit", file, length={"is_metric": True, "raw": "MILLIMETERS"})
    model = api.run("context.add_context", file, context_type="Model")
    body = api.run(
        "context.add_context",
        file,
        context_type="Model",
        context_identifier="Body",
        target_view="MODEL_VIEW",
        parent=model,
    )
    wall = api.run("root.create_entity", file, ifc_class="IfcWall", name="wall")
    place = np.eye(4)
    place[:2, :2] = [[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]]
    place[:3, 3] = 1.0, 2.0, 0.0
    api.run("geometry.edit_object_placement", file, product=wall, matrix=place)
    size = {"length": 2.0, "height": 1.0, "thickness": 0.5, "offset": offset}
    shape = api.run("geometry.add_wall_representation", file, context=body, **size)
    api.run("geometry.assign_representation", file, product=wall, representation=shape)
    if not layers:
        return file, wall, shape, body
    of = "IfcMaterialLayerSet"
    several = api.run("material.add_material_set", file, name="layers", set_type=of)
    for name, category, thickness in layers:
        material = api.run("material.add_material", file, name=name, category=category)
        one = api.run("material.add_layer", file, layer_set=several, material=material)
        told = {"LayerThickness": 1000.0 * thickness}
        api.run("material.edit_layer", file, layer=one, attributes=told)
    usage = f"{of}Usage"
    api.run("material.assign_material", file, products=[wall], type=usage, material=several)
    (used,) = file.by_type(usage)
    used.DirectionSense = sense
    used.OffsetFromReferenceLine = 1000.0 * (offset if sense == "POSITIVE" else offset + 0.5)
    return file, wall, shape, body
