"""
A tooth for CalculiX
====================

A tooth of hexahedra, loaded with 1 kN by the Hertzian pressure of the mating flank, and fixed in the bore
and at its cut sides. Run ``ccx tooth`` to solve ``tooth.inp``.
"""

from pathlib import Path

import matplotlib.pyplot as plt
from pyvista import Plotter

from beveloid_geom import builtin_design, tooth_hexahedra
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export.fea.volumes import write_volume
from beveloid_geom.export.parts import contact_case
from beveloid_viz import require_opengl, to_pyvista

design = builtin_design()
tooth = tooth_hexahedra(design.pinion, element="C3D8I", tolerance=0.2)
case = contact_case(tooth, design, meshing_pair(design, "right"), member=0, force=1000.0)
write_volume(tooth, Path("tooth.inp"), "C3D8I", case=case)

require_opengl()  # select an OpenGL without a screen before VTK looks for one
plotter = Plotter(off_screen=True, window_size=(900, 700))
plotter.add_mesh(to_pyvista(tooth), color="lightsteelblue", show_edges=True)
plotter.camera.zoom(1.4)
figure, axes = plt.subplots(figsize=(4.5, 3.5), layout="constrained")
axes.imshow(plotter.screenshot(return_img=True))
axes.set_axis_off()
plt.show()

semi_axis = float(case.load.ellipse.semi_axes.max())
print(f"{len(tooth.points)} nodes; the contact ellipse has a major semi-axis of {semi_axis:.7f} mm")
