"""
First contact and transmission error
====================================

The tooth pair in contact, on the flank or on an edge, over one mesh cycle.
"""

import matplotlib.pyplot as plt
import numpy as np

from beveloid_geom import builtin_design, mesh_cycle

design = builtin_design().with_parabola(pinion=0.001, gear=-0.001)
cycle = mesh_cycle(design, "right")
roll = float(cycle.start) + np.linspace(0.0, 1.0, 241) * cycle.pitch
first = cycle.at(roll)  # the same as first_contact(design, "right", roll), from the segments of the cycle
error = np.degrees(first.transmission_error) * 3600.0
edge = first.limit[:, 0] >= 0  # first of up to two edges that touch, -1 for none

figure, axes = plt.subplots(figsize=(5.0, 3.5), layout="constrained")
axes.plot(np.degrees(roll), np.where(edge, np.nan, error), label="flank on flank")
axes.plot(np.degrees(roll), np.where(edge, error, np.nan), label="an edge touches")
axes.set(xlabel="pinion roll (deg)", ylabel="transmission error: gear ahead (arcsec)")
axes.legend()
plt.show()

peak_to_peak = float(cycle.peak_to_peak)
print(f"{np.degrees(peak_to_peak) * 3600.0:.7f} arcsec peak to peak, edge contact {cycle.edge_share:.1%}")
