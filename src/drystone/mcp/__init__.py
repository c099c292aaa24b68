"""A server for programs that use tools: the Model Context Protocol over standard input and output.

``drystone mcp FOLDER`` starts it. The extra ``mcp`` installs the package of the protocol.
"""

from drystone.mcp.server import serve

__all__ = ["serve"]
