"""
A solid for CAD
===============

A gear as a closed surface of triangles within 0.02 mm, written as STL. For STEP, a solid of B-splines with
named faces, ``beveloid_geom.export.step.write_step(gear, "gear.step")`` needs the extra ``step``.
"""

import matplotlib.pyplot as plt
from pyvista import Plotter

from beveloid_geom import builtin_design, gear_solid
from beveloid_viz import require_opengl, to_pyvista

surface = to_pyvista(gear_solid(builtin_design().gear, tolerance=0.02))
surface.save("gear.stl")

require_opengl()  # select an OpenGL without a screen before VTK looks for one
plotter = Plotter(off_screen=True, window_size=(900, 700))
plotter.add_mesh(surface, color="lightsteelblue", split_sharp_edges=True, smooth_shading=True)
plotter.view_vector((0.3, -0.6, 1.0), viewup=(0.0, 1.0, 0.0))
plotter.camera.zoom(1.3)
figure, axes = plt.subplots(figsize=(4.5, 3.5), layout="constrained")
axes.imshow(plotter.screenshot(return_img=True))
axes.set_axis_off()
plt.show()

volume = float(surface.volume)
print(f"{surface.n_cells} triangles around {volume:.3f} mm^3, open edges: {surface.n_open_edges}")
