"""
In a notebook
=============

Designs and results are shown as tables. Surfaces become PyVista meshes that carry results at their points.
"""

import matplotlib.pyplot as plt
import numpy as np
from pyvista import Plotter

from beveloid_geom import builtin_design, path_of_contact, sample_flank
from beveloid_geom.operation.angular_clearance import angular_clearance
from beveloid_viz import require_opengl, to_pyvista

path = path_of_contact(builtin_design().with_parabola(pinion=0.001, gear=-0.001), "right")
path

# %%
# Distance of the pinion flank from the gear flank along the normal of the gear flank, in the middle of the
# path, at points of the pinion flank.
grid = sample_flank(path.design.pinion, "right", tolerance=0.0005)
rolls = path.pinion_roll[50], path.gear_roll[50]
apart = angular_clearance(path.design, "right", 0, grid.l, grid.z, *rolls).distance
surface = to_pyvista(grid)
surface["separation (mm)"] = apart.ravel()

require_opengl()  # select an OpenGL without a screen before VTK looks for one
plotter = Plotter(off_screen=True, window_size=(600, 800))
bar = {"fmt": "%.1f", "n_labels": 3, "position_x": 0.2}
plotter.add_mesh(surface, cmap="viridis", clim=(0.0, 1.0), lighting=False, scalar_bar_args=bar)
plotter.view_vector(-grid.normals[len(grid.l) // 2, len(grid.z) // 2], viewup=(0.0, 0.0, 1.0))
figure, axes = plt.subplots(figsize=(3.0, 4.0), layout="constrained")
axes.imshow(plotter.screenshot(return_img=True))
axes.set_axis_off()
plt.show()

greatest = float(np.nanmax(apart))
print(f"up to {greatest:.7f} mm apart")
