"""
Misalignment
============

Any quantity of a design may be an array: one call computes a pair with 201 errors of the offset.
"""

import matplotlib.pyplot as plt
import numpy as np

from beveloid_geom import Errors, builtin_design, path_of_contact

design = builtin_design().with_parabola(pinion=0.001, gear=-0.001)
offsets = np.linspace(-0.2, 0.2, 201)
paths = path_of_contact(design.with_errors(Errors(offset=offsets)), "right", points=3)

figure, axes = plt.subplots(figsize=(5.0, 3.5), layout="constrained")
for column, name in enumerate(("where it enters", "mid-roll", "where it leaves")):
    axes.plot(offsets, paths.pinion_z[:, column], label=name)
axes.set(xlabel="offset error (mm)", ylabel="z of the path on the pinion (mm)")
axes.legend()
plt.show()

shift_per_mm = float(np.gradient(paths.pinion_z[:, 1], offsets)[100])
print(f"mid-roll moves by {shift_per_mm:.7f} mm along the face for 1 mm of offset")
