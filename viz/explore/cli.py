"""`explore-pair`: an interactive view of a gear pair in the browser."""

from __future__ import annotations

import asyncio
import signal
import webbrowser
from contextlib import suppress
from importlib.util import find_spec
from typing import Any

import click

from beveloid_geom.cli.options import (
    BUILTIN_DESIGN,
    NumberRange,
    Refusal,
    changed_design,
    flank_option,
    load_design,
    override_options,
    write_out,
)

from ..options import command, option

FILM = "Thickness of the marking compound: largest separation in the pattern and in a second contact ratio."
TORQUE = "Torque on the pinion for the largest pressure (Hertz); 0 for none."


@command("explore-pair")
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@option("--film", NumberRange(0.0, 10.0), 0.00635, FILM, "MM")
@option("--torque", NumberRange(0.0, 1e12), 0.0, TORQUE, "NM")
@option("--port", click.IntRange(0, 65535), 0, "Port on this machine; 0 for a free one.")
@click.option("--browser/--no-browser", default=True, show_default=True, help="Open the browser.")
@override_options
def main(
    design: str, flank: str, film: float, torque: float, port: int, browser: bool, **changes: Any
) -> None:
    """Show a DESIGN, a TOML file or a built-in name, in the browser, and change it with sliders.

    The teeth in mesh, the flattened flanks with path, first contacts and pattern, the motion graph and the
    main numbers follow the sliders. The page comes from this machine; nothing is sent to the network. The
    address contains a random token. Ctrl-C ends the program."""
    install = "pip install 'beveloid-geom[explore]'"
    changed = changed_design(load_design(design), changes)
    if find_spec("aiohttp") is None:
        raise Refusal([f"explore-pair needs the package aiohttp: {install}"])
    from .server import HOST, Server
    from .values import Start, ViewSettings

    name, given = click.format_filename(design), {k: x for k, x in changes.items() if x is not None}
    try:
        server = Server(Start(changed, name, ViewSettings(flank, film, torque), given), port)
    except OSError as error:
        cure = "choose another port, or omit --port for a free one"
        raise Refusal([f"--port {port} of {HOST} cannot be used ({error.strerror}): {cure}"]) from None
    write_out(f"{server.url}\nCtrl-C ends the program.\n")
    if browser and not webbrowser.open(server.url):
        click.echo("No browser was found: open the address above in a browser.", err=True)
    asyncio.run(_serve(server))


async def _serve(server: Any) -> None:
    """Serve until Ctrl-C or the end of the terminal, which are the usual ends."""
    stop = asyncio.Event()
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        with suppress(AttributeError, NotImplementedError):  # Windows has other signals
            asyncio.get_running_loop().add_signal_handler(getattr(signal, name), stop.set)
    await server.run(stop)
