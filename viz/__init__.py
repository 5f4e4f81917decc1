"""Pictures of what `beveloid_geom` computes: the figures of Ni et al. 2017 as 3D renderings."""
