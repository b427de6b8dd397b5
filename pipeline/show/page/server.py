"""The server of the page: on the loopback address only, for pages that come from there."""

import contextlib
import io
import re
from typing import TYPE_CHECKING, Any

from pipeline.errors import UsageError

if TYPE_CHECKING:
    from viser import ViserServer

HOST = "127.0.0.1"
_OWN_PAGES = re.compile(r"https?://(127\.0\.0\.1|localhost|\[::1\])(:\d+)?")
_FOREIGN = 1008
"""Code with which a connection is closed that a policy forbids."""


def open_server(port: int, label: str) -> "ViserServer":
    """Serve an empty page at a port, 0 for any free one.

    Raises
    ------
    UsageError
        When viser is not installed, or the port is in use or may not be used.
    """
    try:
        import viser
    except ModuleNotFoundError as error:
        raise UsageError(
            f"show needs the library viser, which is not installed ({error.name} is missing).\n"
            "  What to change: pip install 'gantry-tau[show]'."
        ) from None
    # It announces itself, and that it has ended, on standard output.
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=HOST, port=port, label=label, verbose=False)
    if port and server.get_port() != port:
        close_server(server)
        raise UsageError(f"--port {port} is in use, or may not be used: give another one, or 0 for any free one")
    _keep_local(server)
    server.gui.configure_theme(
        show_logo=False, show_share_button=False, control_width="large", brand_color=(0, 114, 178)
    )
    return server


def close_server(server: "ViserServer") -> None:
    """End the server and its connections."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def _keep_local(server: "ViserServer") -> None:
    """Refuse what a page from elsewhere could ask for in the user's browser, and to be made public by a tunnel.

    A browser lets any page connect to the loopback address, but tells where the page comes from.
    """
    from viser import _messages

    inner: Any = server._websock_server
    inner.unregister_handler(_messages.ShareUrlRequest)

    async def refuse_foreign(connection: Any) -> None:
        socket = inner._live_connections[connection.client_id]
        origin = socket.request.headers.get("Origin")
        if origin is not None and not _OWN_PAGES.fullmatch(origin):
            await socket.close(_FOREIGN, "this page is not the program's own")

    inner.on_client_connect(refuse_foreign)
