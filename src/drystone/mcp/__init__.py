"""A server for programs that use tools: the Model Context Protocol over standard input and output.

``drystone mcp FOLDER`` starts it. The extra ``mcp`` brings the protocol's own package.
"""

from drystone.mcp.server import serve

__all__ = ["serve"]
