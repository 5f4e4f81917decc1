"""
A new figure
============

Scenes hold surfaces, tubes and arrows. A `Picture` returns the pixel of a point, so that text is placed
over the picture.
"""

import matplotlib.pyplot as plt

from beveloid_geom import builtin_design, path_of_contact, sample_flank
from beveloid_geom.gear.flank import flank_point
from beveloid_viz import Scene, Tube, fit_camera, grid_surface, render, require_opengl

design = builtin_design().with_parabola(pinion=0.001, gear=-0.001)
flank = sample_flank(design.pinion, "left", tolerance=0.001)
path = path_of_contact(design, "left")
points = flank_point(design.pinion, "left", path.l1, path.u1)

items = grid_surface(flank.points, flank.normals, "#b9c4cf", edges=True), Tube(points, "#c8102e", radius=0.2)
size = (500, 700)
camera = fit_camera(flank.points, direction=-flank.normals[10, 3], up=(0.0, 0.0, 1.0), size_px=size)
require_opengl()  # select an OpenGL without a screen before VTK looks for one
picture = render(Scene(items, camera), size)

figure, axes = plt.subplots(figsize=(3.5, 4.5), layout="constrained")
axes.imshow(picture.image)
axes.annotate("enters", picture.project(points[0]), xytext=(-12, 0), textcoords="offset points", ha="right")
axes.annotate("leaves", picture.project(points[-1]), xytext=(12, 0), textcoords="offset points")
axes.set_axis_off()
plt.show()

px_per_mm = picture.px_per_mm
print(f"{px_per_mm:.3f} pixels a mm")
