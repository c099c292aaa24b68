"""The tools in the form of the protocol: names, arguments, descriptions."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

import anyio
from anyio import to_process
from mcp.server import MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp.types import ToolAnnotations
from pydantic import BaseModel, ConfigDict, Field

import drystone
from drystone.mcp.answers import answer
from drystone.mcp.folder import Folder

INSTRUCTIONS = """\
drystone tells whether a structure of loose rigid blocks stands by contact and friction alone.
Lengths are in metres, forces in newtons, angles in degrees, masses in kilograms; z points up.
A model is a file in the folder of this server or an object: {"blocks": [{"name", "vertices",
"faces", "fixed"}]}, faces as lists of vertex numbers, counter-clockwise from outside.
Begin with 'inspect' where the contacts are not known to be right. 'undecided' is an answer: it is
no hint in either direction."""

Number = Annotated[float, Field(allow_inf_nan=False)]
Loads = Annotated[
    list[dict[str, Any]],
    Field(
        description='Parts that are added up: {"kind": "point", "block", "force": [x, y, z] in N, '
        '"at": point in m}, {"kind": "seismic", "kx", "ky"} as shares of the weight, '
        '{"kind": "mass", "block", "mass" in kg}, {"kind": "moment", "block", "moment"}, '
        '{"kind": "surface", "block", "pressure", "facing"}; each may have a "factor".'
    ),
]


class ModelArguments(BaseModel):
    """A model, its supports, materials and loads."""

    model_config: ClassVar[ConfigDict] = {"extra": "forbid"}

    file: str | None = Field(None, description="Name of a model file in the folder.")
    content: dict[str, Any] | None = Field(
        None, description="The model itself, as drystone JSON or COMPAS JSON, instead of a file."
    )
    supports: str | list[str] | None = Field(
        None,
        description="Fixed blocks: 'lowest', 'below:Z', names and patterns separated by commas, or "
        "a list of names. Left out, those that the model marks.",
    )
    friction: Number | None = Field(
        None, ge=0.0, description="Coefficient of all joints. Left out, that of the model, or 0.6."
    )
    density: Number | None = Field(
        None, gt=0.0, description="Of all blocks in kg/m3. Left out, that of the model, or 2400."
    )
    units: str | None = Field(None, description="Unit of length of a file: mm, cm, m, in or ft.")
    gravity: Number | tuple[Number, Number, Number] | None = Field(
        None, description="In m/s2: its size along -z, or a vector. Left out, 9.81."
    )
    loads: Loads | None = Field(None, description="Loads on top of the weight; see 'limit'.")


Model = Annotated[ModelArguments, Field(description="The model to analyse.")]
Answer = dict[str, Any]


def build(folder: Folder, seconds: float) -> MCPServer[Any]:
    """A server whose tools work on the models of a folder.

    Calls are answered one after the other, each in a process of its own with a time limit.

    Parameters
    ----------
    folder
    seconds
        For one call.
    """
    one = anyio.Lock()

    async def ask(tool: str, **given: Any) -> Answer:
        async with one:
            try:
                with anyio.fail_after(seconds):
                    told = await to_process.run_sync(
                        answer, tool, given, folder, seconds, cancellable=True
                    )
            except TimeoutError:
                raise ToolError(
                    f"no answer within {seconds:g} s; give a smaller model, or start the server "
                    "with a larger --time-limit"
                ) from None
            except anyio.BrokenWorkerProcess:
                raise ToolError(
                    "the calculation ended without an answer, perhaps because memory ran out; "
                    "give a smaller model"
                ) from None
        if "error" in told:
            raise ToolError(told["error"])
        return told

    async def files() -> Answer:
        """List the model files in the folder of this server."""
        return await ask("files")

    async def inspect(model: Model) -> Answer:
        """Blocks, volumes and defects of a model, and the contacts that are found and missed."""
        return await ask("inspect", model=model.model_dump())

    async def check(model: Model) -> Answer:
        """Does a model stand? Verdict, blocks that fall, what a prop would carry, largest forces.

        'stable' and 'unstable' are proved. 'sensitive': it stands for some contact stiffnesses of
        those that were tried, and not for all.
        """
        return await ask("check", model=model.model_dump())

    async def diagnose(
        model: Model,
        needs: Annotated[
            bool, Field(description="Search what would hold each region; false is much faster.")
        ] = True,
    ) -> Answer:
        """Why does a model fall, and what would hold it? One sentence for each region that falls.

        'needs' of a region: the force that is missing and its point, a support from below,
        the least friction, ballast on one block, turn of one joint, and whether glue would hold.
        """
        return await ask("diagnose", model=model.model_dump(), needs=needs)

    async def limit(
        model: Model,
        of: Annotated[
            Literal["tilt", "friction", "load", "shrink"],
            Field(
                description="tilt: largest angle in degrees. friction: least coefficient. load: "
                "largest factor of 'load'. shrink: least share of the size of all joints, whose "
                "inverse is a geometric safety factor."
            ),
        ],
        axis: Annotated[
            Literal["x", "y", "z", "-x", "-y"], Field(description="Of the tilt.")
        ] = "x",
        load: Loads | None = None,
    ) -> Answer:
        """By how much does a model stand? A bracket: stands at one value, falls at the other.

        'equilibrium' is where some forces balance the loads, 'rest' where it comes to rest for
        some contact stiffness, 'uniform' for a uniform one.
        """
        return await ask("limit", model=model.model_dump(), of=of, axis=axis, load=load)

    async def mend(
        model: Model,
        kinds: Annotated[
            list[str] | None,
            Field(
                description="Kinds that are tried; left out, all: support, prop, tie, friction, "
                "turn, wedge, let-in, thicker, ballast, glue, merge."
            ),
        ] = None,
        keep: Annotated[
            list[str] | None,
            Field(description="Blocks that may not be changed: names and patterns."),
        ] = None,
    ) -> Answer:
        """Which changes make a model stand? Each was checked on the whole model, cheapest first.

        'mends' lists them by region, 'tried' those that are not enough.
        """
        return await ask("mend", model=model.model_dump(), kinds=kinds, keep=keep)

    async def plan(
        model: Model,
        hands: Annotated[int, Field(ge=1, le=10, description="One places, others hold.")] = 2,
        order: Annotated[
            Literal["top", "course", "boundary"],
            Field(description="How it is taken apart: from the top, by courses, from the middle."),
        ] = "top",
        anyway: Annotated[
            bool, Field(description="Plan even if the complete model does not stand.")
        ] = False,
    ) -> Answer:
        """In which order to assemble a model so that every stage stands: what to hold and to prop.

        Counts of free, held, propped and impossible blocks, the order, and the force of each prop.
        """
        return await ask("plan", model=model.model_dump(), hands=hands, order=order, anyway=anyway)

    server: MCPServer[Any] = MCPServer(
        "drystone",
        instructions=INSTRUCTIONS,
        version=drystone.__version__,
        log_level="WARNING",
    )
    reads = ToolAnnotations(read_only_hint=True, open_world_hint=False)
    for tool in (files, inspect, check, diagnose, limit, mend, plan):
        server.add_tool(tool, annotations=reads)
    return server
