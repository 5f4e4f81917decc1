"""
Choosing a modification
=======================

Parabola coefficients that minimise the shift of the path under assembly errors, with a contact ratio of at
least 1.5.
"""

import matplotlib.pyplot as plt
import numpy as np

from beveloid_geom import Aim, Errors, builtin_design, optimise_parabola, path_of_contact

errors = Errors(offset=0.05, shaft_angle=np.radians(0.01))
best = optimise_parabola(builtin_design(), Aim(errors, contact_ratio=1.5), "right")

figure, axes = plt.subplots(figsize=(5.0, 4.0), layout="constrained")
for design, colour in (builtin_design(), "tab:orange"), (best.design, "tab:blue"):
    label = f"$a_1$ = {design.pinion.tool.parabola:.5f}, $a_2$ = {design.gear.tool.parabola:.5f} 1/mm"
    for given, dash in (Errors(), "-"), (errors, "--"):
        path = path_of_contact(design.with_errors(given), "right")
        axes.plot(path.pinion_z, path.pinion_r, dash, color=colour, label=label if dash == "-" else None)
axes.set(xlabel="z from mid-face, heel on the right (mm)", ylabel="radius on the pinion (mm)")
axes.set_title("solid: as designed, dashed: under errors", fontsize="medium")
axes.legend(fontsize="small")
plt.show()

contact_ratio = float(best.optimum.contact_ratio)
print(f"contact ratio {contact_ratio:.7f}")
