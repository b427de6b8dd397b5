"""The server of the page: on this machine only, for its own pages, at the port that was asked for."""

import socket
import sys
from collections.abc import Iterator

import pytest

from pipeline.errors import UsageError
from pipeline.show.page.server import HOST, close_server, open_server

viser = pytest.importorskip("viser")


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    """Open a server at any free port."""
    opened = open_server(0, "test")
    yield opened
    close_server(opened)


def connect(server: viser.ViserServer, origin: str | None):
    """Connect as a page from somewhere does."""
    from websockets.sync.client import connect

    address = f"ws://{HOST}:{server.get_port()}"
    return connect(address, origin=origin, subprotocols=[f"viser-v{viser.__version__}"])


def test_it_is_on_the_loopback_address(server: viser.ViserServer) -> None:
    """No other address of this machine listens at the port."""
    assert server.get_host() == HOST == "127.0.0.1"
    assert server.get_port() > 0
    with pytest.raises(OSError, match=r".*"), socket.create_connection(("127.0.0.2", server.get_port()), timeout=5.0):
        pass


@pytest.mark.parametrize("origin", ["http://127.0.0.1:{port}", "http://localhost:{port}", None])
def test_its_own_page_is_served(server: viser.ViserServer, origin: str | None) -> None:
    """A page from this machine, and a program, get the scene."""
    with connect(server, origin and origin.format(port=server.get_port())) as connection:
        assert len(connection.recv(timeout=30.0)) > 0


@pytest.mark.parametrize("origin", ["https://example.org", "http://127.0.0.1.example.org", "null"])
def test_pages_from_elsewhere_are_refused(server: viser.ViserServer, origin: str) -> None:
    """A page that the user's browser has from elsewhere is told nothing, and can ask for nothing."""
    from websockets.exceptions import ConnectionClosed

    with connect(server, origin) as connection, pytest.raises(ConnectionClosed) as closed:
        connection.recv(timeout=30.0)
    assert closed.value.rcvd.code == 1008


def test_nobody_can_make_it_public(server: viser.ViserServer) -> None:
    """Requests for a public address, which viser has, are not handled."""
    from viser import _messages

    assert _messages.ShareUrlRequest not in server._websock_server._incoming_handlers


def test_a_port_in_use_is_refused(server: viser.ViserServer) -> None:
    """Another port is not taken in silence."""
    with pytest.raises(UsageError, match=f"--port {server.get_port()} is in use"):
        open_server(server.get_port(), "other")


def test_without_viser_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """One line says what is missing and how to get it."""
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(UsageError, match=r"pip install 'gantry-tau\[show\]'") as missing:
        open_server(0, "none")
    assert missing.value.exit_code == 2
