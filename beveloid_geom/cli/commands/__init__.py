"""The commands of `beveloid-geom`: one package for each section of the help, one module for each command."""
