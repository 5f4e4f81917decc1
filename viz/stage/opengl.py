"""Find an OpenGL that can draw offscreen, before VTK looks for one itself.

VTK ends the interpreter with a segmentation fault where it finds none. So a window class is
chosen here from the libraries that load, and a child process draws one small picture with it
first.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping

VARIABLE = "VTK_DEFAULT_OPENGL_WINDOW"
OSMESA = "vtkOSOpenGLRenderWindow"
EGL = "vtkEGLRenderWindow"
LIBRARIES = {
    OSMESA: ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),
    EGL: ("libEGL.so.1", "libEGL.so"),
}
PROBE_SECONDS = 60.0
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
    """No OpenGL that draws offscreen; the message is one line naming the package to install."""


def _loads(names: tuple[str, ...]) -> bool:
    for name in names:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def window_classes(environment: Mapping[str, str], platform: str = sys.platform) -> Iterator[str]:
    """Give window classes worth trying, best first; the empty name is VTK's own choice.

    What the user has set is the only one. Mesa's software renderers come first on a machine
    without a screen."""
    if environment.get(VARIABLE):
        yield environment[VARIABLE]
        return
    if not platform.startswith("linux") or environment.get("DISPLAY"):
        yield ""
    if platform.startswith("linux"):
        yield from (name for name, libraries in LIBRARIES.items() if _loads(libraries))


def draws(window_class: str) -> bool:
    """Say whether a child process draws a picture with this window class."""
    environment = dict(os.environ)
    if window_class:
        environment[VARIABLE] = window_class
    try:
        done = subprocess.run(
            [sys.executable, "-c", PROBE],
            env=environment,
            capture_output=True,
            timeout=PROBE_SECONDS,
            check=False,
        )
    except (OSError, subprocess.SubprocessError):
        return False
    return done.returncode == 0 and b"drawn" in done.stdout


def require_opengl() -> None:
    """Choose a window class that draws and tell VTK so, before the first picture of a program.

    Raises
    ------
    MissingOpenGLError
        Where none draws; the message names the package to install.
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
