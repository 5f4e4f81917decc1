"""The interactive view in a notebook."""

from __future__ import annotations

import asyncio
import html
import threading

from beveloid_geom import Design
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.design.arguments import require_single

from .server import Server
from .values import Start, ViewSettings


class Exploration:
    """Running view of a pair; a notebook shows it where it is the value of a cell.

    Attributes
    ----------
    url : str
        Address for a browser on this machine.
    """

    def __init__(self, server: Server) -> None:
        """Serve in a thread until `close` is called or Python ends."""
        self.url, self._stop = server.url, asyncio.Event()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._serve, args=(server,), daemon=True)
        self._thread.start()

    def _serve(self, server: Server) -> None:
        """Run the event loop of the server."""
        try:
            self._loop.run_until_complete(server.run(self._stop))
        finally:
            self._loop.close()

    def close(self) -> None:
        """End the server. Further calls do nothing."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join()

    def _repr_html_(self) -> str:
        """Return a frame with the page."""
        style = "width: 100%; height: 900px; border: 0"
        return f'<iframe src="{html.escape(self.url)}" title="Gear pair" style="{style}"></iframe>'


def explore(
    design: Design,
    flank: str = "right",
    *,
    film: float = MARKING_SEPARATION_MM,
    torque: float = 0.0,
    name: str = "design",
    port: int = 0,
) -> Exploration:
    """Start the interactive view of a design, as the command `explore-pair` does.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
        Driving flanks.
    film : float
        Film thickness, mm.
    torque : float
        Torque on the pinion, Nm; 0 for no pressure.
    name : str
        Name of the design on the page.
    port : int
        Port on this machine; 0 for a free one.

    Returns
    -------
    Exploration
        A notebook shows the view if this is the last expression of a cell.

    Raises
    ------
    ValueError
        For a batch of designs, and for settings outside their limits (DesignError).
    OSError
        If the port is not free.
    """
    require_single(design)
    start = Start(design, name, ViewSettings(flank, film, torque))
    start.read(start.values)
    return Exploration(Server(start, port))
