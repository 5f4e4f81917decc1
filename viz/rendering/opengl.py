"""Select an OpenGL library for off-screen drawing before VTK does.

VTK ends the interpreter with a segmentation fault if there is no OpenGL. Therefore the window class is
selected here from the libraries that can be loaded, and a child process draws a small picture with it first.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from functools import cache

VARIABLE = "VTK_DEFAULT_OPENGL_WINDOW"
PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
renderer = vtkRenderer()
renderer.SetBackground(1.0, 1.0, 1.0)
window.AddRenderer(renderer)
window.Render()
image = vtkWindowToImageFilter()
image.SetInput(window)
image.Update()
print("drawn" if image.GetOutput().GetScalarRange()[1] > 0.0 else "blank")
"""


class MissingOpenGLError(RuntimeError):
    """No OpenGL library can draw off screen. The message is one line that names the package to install."""


def _loads(names: tuple[str, ...]) -> bool:
    for name in names:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def window_classes(environment: Mapping[str, str], platform: str = sys.platform) -> Iterator[str]:
    """Return the names of window classes to try, best first; the empty name is the default of VTK.

    A class that the user has set is the only candidate. Without a display, the software renderers of Mesa
    come first.
    """
    libraries_of = {
        "vtkOSOpenGLRenderWindow": ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),
        "vtkEGLRenderWindow": ("libEGL.so.1", "libEGL.so"),
    }
    if environment.get(VARIABLE):
        yield environment[VARIABLE]
        return
    if not platform.startswith("linux") or environment.get("DISPLAY"):
        yield ""
    if platform.startswith("linux"):
        yield from (name for name, libraries in libraries_of.items() if _loads(libraries))


@cache
def draws(window_class: str) -> bool:
    """Return True if a child process can draw a picture with this window class; tried once per process."""
    probe_seconds = 60.0
    environment = dict(os.environ)
    if window_class:
        environment[VARIABLE] = window_class
    try:
        done = subprocess.run(
            [sys.executable, "-c", PROBE],
            env=environment,
            capture_output=True,
            timeout=probe_seconds,
            check=False,
        )
    except (OSError, subprocess.SubprocessError):
        return False
    return done.returncode == 0 and b"drawn" in done.stdout


def require_opengl() -> None:
    """Select a window class that can draw, and set it for VTK. Call before the first picture of a program.

    Raises
    ------
    MissingOpenGLError
        If no window class can draw; the message names the package to install.
    """
    for name in window_classes(os.environ):
        if draws(name):
            if name:
                os.environ[VARIABLE] = name
            return
    chosen = os.environ.get(VARIABLE)
    raise MissingOpenGLError(
        (f"OpenGL cannot draw with {VARIABLE}={chosen}: unset it, or" if chosen else "no OpenGL found:")
        + " install Mesa with `sudo apt-get install libosmesa6`"
        " (`libegl1 libgl1-mesa-dri` where there is no libosmesa6)"
    )
