"""Web server: token, host, origin, files; the command and its refusals."""

from __future__ import annotations

import re
import socket
import urllib.error
import urllib.request
from collections.abc import Callable
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import numpy as np
import pytest

from beveloid_geom import Design, builtin_design
from beveloid_viz.explore.cli import main
from tests.cli.running import refused

if TYPE_CHECKING:
    from beveloid_viz.explore.notebook import Exploration

Explored = Callable[..., "Exploration"]


def handshake(url: str, **headers: str) -> int:
    """Return the status of a request for a websocket."""
    parts = urlsplit(url)
    lines = {"Host": parts.netloc, "Connection": "Upgrade", "Upgrade": "websocket", **headers}
    lines |= {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Version": "13"}
    text = "".join(f"{key}: {value}\r\n" for key, value in lines.items())
    with socket.create_connection((str(parts.hostname), int(parts.port or 0)), timeout=10.0) as line:
        line.sendall(f"GET {parts.path} HTTP/1.1\r\n{text}\r\n".encode())
        return int(line.recv(100).split()[1])


def status(url: str, **headers: str) -> int:
    request = urllib.request.Request(url, headers=headers)
    try:
        with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=10) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        with error:
            return error.code


@pytest.fixture(scope="module")
def url(explored: Explored) -> str:
    return explored(builtin_design()).url


def test_everything_needs_the_token(url: str) -> None:
    host = url.rsplit("/", 2)[0]
    assert len(urlsplit(url).path.strip("/")) >= 32
    for file in ("", "explore.js", "data.json"):
        assert status(url + file) == HTTPStatus.OK
        for other in ("", "x", "%00", "\u00e9".encode().hex()):
            assert status(f"{host}/{other}/{file}") == HTTPStatus.FORBIDDEN
    assert status(f"{host}/") == HTTPStatus.FORBIDDEN
    assert handshake(f"{host}/x/socket") == HTTPStatus.FORBIDDEN
    assert handshake(url + "socket") == HTTPStatus.SWITCHING_PROTOCOLS


def test_other_hosts_and_origins_are_refused(url: str) -> None:
    assert status(url, Host="evil.example") == HTTPStatus.FORBIDDEN
    assert handshake(url + "socket", Origin="http://evil.example") == HTTPStatus.FORBIDDEN


@pytest.mark.parametrize("file", ["../cli.py", "cli.py", "%2e%2e/cli.py", "/etc/passwd", "three.min.js"])
def test_only_the_files_of_the_page_are_served(url: str, file: str) -> None:
    assert status(url + file) in (HTTPStatus.NOT_FOUND, HTTPStatus.FORBIDDEN)


def test_the_server_listens_on_this_machine_only(url: str) -> None:
    port = urlsplit(url).port
    assert port
    for address in {each[4][0] for each in socket.getaddrinfo(socket.gethostname(), port, socket.AF_INET)}:
        if not str(address).startswith("127."):
            with pytest.raises(OSError, match=r"refused|unreachable"):
                socket.create_connection((str(address), port), timeout=2.0)


def test_tokens_differ_and_closing_ends_the_server(explored: Explored, modified: Design) -> None:
    one, other = explored(modified), explored(modified)
    assert urlsplit(one.url).path != urlsplit(other.url).path
    assert one.url in one._repr_html_()
    one.close()
    one.close()
    with pytest.raises(urllib.error.URLError):
        status(one.url)


def test_the_example_of_the_page_runs(explored: Explored) -> None:
    """`explored` skips the test without the extra."""
    page = Path(__file__).parents[3] / "viz/explore/README.md"
    (example,) = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    scope: dict[str, Any] = {}
    exec(compile(example, str(page), "exec"), scope)
    try:
        assert status(scope["view"].url) == HTTPStatus.OK
    finally:
        scope["view"].close()


def test_a_batch_and_refused_settings(explored: Explored, modified: Design) -> None:
    with pytest.raises(ValueError, match="single design"):
        explored(modified.with_parabola(np.array([0.0, 0.001])))
    with pytest.raises(ValueError, match="film must be between"):
        explored(modified, film=-1.0)


def test_without_the_extra_one_line_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("beveloid_viz.explore.cli.find_spec", lambda name: None)
    line = refused("--no-browser", program=main)
    assert line == "Error: explore-pair needs the package aiohttp: pip install 'beveloid-geom[explore]'\n"


def test_a_busy_port_and_a_bad_design_are_refused(url: str, tmp_path: Path) -> None:
    port = str(urlsplit(url).port)
    line = refused("--no-browser", "--port", port, program=main)
    assert line.startswith(f"Error: --port {port} of 127.0.0.1 cannot be used (Address")
    refused("--no-browser", tmp_path / "none.toml", program=main)
