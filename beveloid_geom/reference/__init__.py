"""The paper's five equations written by other code than the solver, to check its numbers with.

`five_equations_math` is scalar `math`, solved by SciPy's `fsolve`; `five_equations_mp` solves them at 60
digits with mpmath, which the package does not install. `pitch_region` says roughly where to start. Of the
package they import the records of `design.model` and nothing else: no flank, no frame, no mounting, no
solver. Their results may be held against any other module's. Single designs only.
"""
