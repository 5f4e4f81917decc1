"""
The pair of the paper
=====================

Path of contact on the right flanks of Table 1 of Ni et al., along face and profile of the pinion. The
parabolas of the tools rotate the path: concave pinion flanks with convex gear flanks (a1 > 0 > a2) in one
sense, convex pinion flanks with concave gear flanks in the other.
"""

import matplotlib.pyplot as plt

from beveloid_geom import builtin_design, path_of_contact

design = builtin_design()
figure, axes = plt.subplots(figsize=(5.0, 4.0), layout="constrained")
for a1, a2 in (0.0, 0.0), (0.001, -0.001), (-0.001, 0.001):
    path = path_of_contact(design.with_parabola(pinion=a1, gear=a2), "right")
    ratio = path.ends.contact_ratio  # Eq. 16
    axes.plot(
        path.pinion_z, path.pinion_r, label=f"$a_1$ = {a1:g}, $a_2$ = {a2:g}: contact ratio {ratio:.3f}"
    )
axes.set(
    xlabel="z from mid-face, heel on the right (mm)", ylabel="radius on the pinion (mm)", xlim=(-20.0, 20.0)
)
figure.legend(loc="outside upper center", fontsize="small")
plt.show()

contact_ratio = float(path_of_contact(design, "right").ends.contact_ratio)
print(f"contact ratio without parabola {contact_ratio:.7f}")
