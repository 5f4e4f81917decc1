"""
A pair of your own
==================

Tools and gears are given; the layout in which they mesh without backlash follows, and then their contact.
"""

import matplotlib.pyplot as plt
import numpy as np

from beveloid_geom import Design, Member, Pair, Tool, path_of_contact, zero_backlash_layout

tool = Tool(normal_module=4.0, normal_pressure_angle=np.radians(20.0))
pinion = Member(tool, 25, np.radians(25.0), np.radians(3.0), profile_shift=0.2, face_width=30.0)
gear = Member(tool, 31, np.radians(15.0), np.radians(3.0), profile_shift=0.0, face_width=30.0)
layout = zero_backlash_layout(Design(pinion, gear, Pair(offset=115.0, shaft_angle=np.radians(40.0))))
play = 0.05  # mm, set by moving the axes apart
pair = Pair(float(layout.offset) + play, float(layout.shaft_angle), *layout.mounting.tolist())
design = Design(pinion, gear, pair)

figure, axes = plt.subplots(figsize=(5.0, 4.0), layout="constrained")
for flank in "left", "right":
    path = path_of_contact(design, flank)
    axes.plot(path.pinion_z, path.pinion_r, label=f"{flank}, contact ratio {path.ends.contact_ratio:.3f}")
axes.set(xlabel="z from mid-face, heel on the right (mm)", ylabel="radius on the pinion (mm)")
axes.legend()
plt.show()

offset = float(layout.offset)
print(f"without backlash at an offset of {offset:.7f} mm and {np.degrees(layout.shaft_angle):.4f} deg")
