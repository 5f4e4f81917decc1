"""
Explore a pair with sliders
===========================

``explore`` opens the window of ``explore-pair`` from Python. It needs the extra ``explore``. In a notebook,
the last line of the cell shows the window; elsewhere, open the address ``view.url`` in a browser.
"""

import matplotlib.pyplot as plt
import numpy as np

from beveloid_geom import Errors, builtin_design, mesh_cycle
from beveloid_viz.explore import explore

design = builtin_design().with_parabola(pinion=0.001, gear=-0.001)
view = explore(design, "right", torque=1000.0)
view

# %%
# The window shows the numbers of the library. This curve is the transmission error that it shows while the
# slider of the offset error is dragged.
offsets = np.linspace(-0.05, 0.05, 41)
cycles = mesh_cycle(design.with_errors(Errors(offset=offsets)), "right")
swing = np.degrees(cycles.peak_to_peak) * 3600.0

figure, axes = plt.subplots(figsize=(5.0, 3.0), layout="constrained")
axes.plot(1e3 * offsets, swing)
axes.set(xlabel="offset error (µm)", ylabel="transmission error,\npeak to peak (arcsec)")
axes.grid(True)
plt.show()

view.close()
at_the_end = float(swing[-1])
print(f"{at_the_end:.7f} arcsec at 50 µm")
