"""
Ten thousand mountings
======================

Random assembly errors, computed in one call, and the position of the path on the face.
"""

import matplotlib.pyplot as plt
import numpy as np

from beveloid_geom import Status, Tolerances, builtin_design, tolerance_study

tolerances = Tolerances(offset=0.05, shaft_angle=np.radians(0.01), pinion_axial=0.05, gear_axial=0.05)
design = builtin_design().with_parabola(pinion=0.001, gear=-0.001)
mountings = tolerance_study(design, tolerances, "right", cases=10_000).mountings
solved = mountings.status == Status.SOLVED

figure, axes = plt.subplots(figsize=(5.0, 3.5), layout="constrained")
axes.hist(mountings.pinion_z[solved, 1], bins=60)
axes.set(xlabel="z at mid-roll on the pinion (mm)", ylabel="mountings")
plt.show()

median_ratio = float(np.median(mountings.contact_ratio[solved]))
print(f"{solved.sum()} of {solved.size} solved; median contact ratio {median_ratio:.7f}")
