"""Web server of the window: the page, its scripts, and one websocket for each window.

The server listens on 127.0.0.1 only. Every address, that of the websocket included, begins with a random
token, which the server checks. Requests with another host name are refused, so that a page of the internet
cannot reach the server by a name that it controls (DNS rebinding).
"""

from __future__ import annotations

import asyncio
import json
import os
import secrets
import socket
from collections.abc import Awaitable, Callable
from contextlib import suppress
from importlib import resources
from typing import Any

from aiohttp import WSMsgType, web

from ..report.view_data import view_data
from .calculation import VIEW_TOLERANCE_MODULES
from .session import Session
from .values import Start

HOST = "127.0.0.1"
FILES = {
    "": ("explore", "page.html", "text/html"),
    "page.css": ("report", "page.css", "text/css"),
    "viewer.css": ("report", "viewer.css", "text/css"),
    "explore.css": ("explore", "explore.css", "text/css"),
    "three.js": ("report", "vendor/three.min.js", "text/javascript"),
    "gears.js": ("report", "gears.js", "text/javascript"),
    "kept_teeth.js": ("report", "kept_teeth.js", "text/javascript"),
    "viewer.js": ("report", "viewer.js", "text/javascript"),
    "panels.js": ("explore", "panels.js", "text/javascript"),
    "scene.js": ("explore", "scene.js", "text/javascript"),
    "explore.js": ("explore", "explore.js", "text/javascript"),
}
"""Package, file and type by address."""
HEADERS = {
    # Styles of single elements set positions of labels.
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline';"
    " connect-src 'self'; img-src 'self' data: blob:; base-uri 'none'; form-action 'none';"
    " frame-ancestors http://localhost:* http://127.0.0.1:*",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Server:
    """Server of one exploration, on a socket that is already bound."""

    def __init__(self, start: Start, port: int = 0) -> None:
        """Bind the socket and compute the teeth of the 3D view.

        Parameters
        ----------
        start : Start
        port : int
            Port; 0 for a free one.

        Raises
        ------
        OSError
            If the port is not free.
        """
        self.start, self.token = start, secrets.token_urlsafe(24)
        self._socket = socket.socket()
        if os.name == "posix":  # on Windows, the option would let two servers share a port
            # Otherwise a port remains busy for a minute after an earlier server.
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._socket.bind((HOST, port))
            self._socket.listen()  # a browser may come before the event loop runs
        except OSError:
            self._socket.close()
            raise
        self.port = int(self._socket.getsockname()[1])
        module = float(start.design.pinion.tool.normal_module)
        self._page_data = {
            "name": start.name,
            "values": start.values,
            "controls": [control.data() for control in start.controls.values()],
            "view": view_data(start.design, VIEW_TOLERANCE_MODULES * module),
        }

    @property
    def url(self) -> str:
        """Address of the page, with the token."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    async def run(self, stop: asyncio.Event) -> None:
        """Serve until `stop` is set."""
        runner = web.AppRunner(
            self._application(), access_log=None, handle_signals=False, shutdown_timeout=1.0
        )
        await runner.setup()
        try:
            await web.SockSite(runner, self._socket).start()
            await stop.wait()
        finally:
            await runner.cleanup()

    def _application(self) -> web.Application:
        """Return the routes, behind the check of token and host."""
        application = web.Application(middlewares=[self._checked()])
        routes = application.router
        routes.add_get("/{token}/data.json", self._send_data)
        routes.add_get("/{token}/socket", self._serve_window)
        routes.add_get("/{token}/{file:.*}", _send_file)
        return application

    def _checked(self) -> Any:
        """Return the check of every request."""
        hosts = {f"{name}:{self.port}" for name in (HOST, "localhost")}

        async def check(request: web.Request, handler: Handler) -> web.StreamResponse:
            """Pass a request on if it has the token, a name of this machine as host, and no other origin."""
            given = request.path.split("/")[1].encode(errors="replace")
            origin = request.headers.get("Origin")
            known = origin is None or origin.removeprefix("http://") in hosts
            if (
                not secrets.compare_digest(given, self.token.encode())
                or request.host not in hosts
                or not known
            ):
                raise web.HTTPForbidden(text="Use the address that explore-pair printed.")
            response = await handler(request)
            if not response.prepared:
                response.headers.update(HEADERS)
            return response

        return web.middleware(check)

    async def _send_data(self, _: web.Request) -> web.Response:
        """Send controls, values of the start, and the 3D view."""
        return web.Response(text=json.dumps(self._page_data), content_type="application/json")

    async def _serve_window(self, request: web.Request) -> web.WebSocketResponse:
        """Answer one window until it is closed."""
        window = web.WebSocketResponse(max_msg_size=100_000, heartbeat=30.0, compress=False)
        await window.prepare(request)
        answers: asyncio.Queue[str] = asyncio.Queue()
        loop = asyncio.get_running_loop()

        def send(text: str) -> None:
            """Queue an answer of the worker thread. It is dropped if the event loop has ended."""
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(answers.put_nowait, text)

        async def forward() -> None:
            """Send the answers until the window is closed."""
            with suppress(ConnectionError):
                while True:
                    await window.send_str(await answers.get())

        session, sender = Session(self.start, send), asyncio.create_task(forward())
        try:
            async for message in window:
                if message.type == WSMsgType.TEXT and (answer := session.receive(message.data)):
                    answers.put_nowait(answer)
        finally:
            session.close()
            sender.cancel()
        return window


async def _send_file(request: web.Request) -> web.Response:
    """Send a file of the page; only those of FILES exist."""
    if request.match_info["file"] not in FILES:
        raise web.HTTPNotFound(text="There is no such file.")
    package, file, kind = FILES[request.match_info["file"]]
    text = (resources.files("beveloid_viz") / package / file).read_text(encoding="utf-8")
    return web.Response(text=text, content_type=kind, charset="utf-8")
