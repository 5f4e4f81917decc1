"""The paper's five equations written three times by other code than the solver, to check its numbers with.

`five_equations_math` is scalar `math`, `five_equations_numpy` NumPy 3-vectors and 4x4 matrices,
both solved by SciPy's `fsolve`; `five_equations_mp` solves them at 60 digits with mpmath.
`pitch_region` says roughly where to start. Of the package they import the records of `design.model`
and nothing else: no flank, no frame, no mounting, no solver. Their results may be held against
any other module's. Single designs only.
"""
