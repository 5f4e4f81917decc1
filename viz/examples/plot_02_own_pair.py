"""
A new pair
==========

From tools and gears to the layout without backlash, and to the contact of the flanks.
"""

import matplotlib.pyplot as plt
import numpy as np

from beveloid_geom import Design, Member, Pair, Tool, from_degrees, path_of_contact, zero_backlash_layout

tool = from_degrees(Tool, normal_module=4.0, normal_pressure_angle_deg=20.0)
blank = {"tool": tool, "face_width": 30.0, "cone_angle_deg": 3.0}
pinion = from_degrees(Member, teeth=25, helix_angle_deg=25.0, profile_shift=0.2, **blank)
gear = from_degrees(Member, teeth=31, helix_angle_deg=15.0, profile_shift=0.0, **blank)
guess = from_degrees(Pair, offset=115.0, shaft_angle_deg=40.0)
layout = zero_backlash_layout(Design(pinion, gear, guess))
extra_offset = 0.05  # mm; a larger offset gives backlash
pair = Pair(float(layout.offset) + extra_offset, float(layout.shaft_angle), *layout.mounting.tolist())
design = Design(pinion, gear, pair)

figure, axes = plt.subplots(figsize=(5.0, 4.0), layout="constrained")
for flank in "left", "right":
    path = path_of_contact(design, flank)
    axes.plot(path.pinion_z, path.pinion_r, label=f"{flank}, contact ratio {path.ends.contact_ratio:.3f}")
axes.set(xlabel="z from mid-face, heel on the right (mm)", ylabel="radius on the pinion (mm)")
axes.legend()
plt.show()

offset = float(layout.offset)
angle = np.degrees(layout.shaft_angle)
print(f"without backlash at an offset of {offset:.7f} mm and a shaft angle of {angle:.4f} deg")
