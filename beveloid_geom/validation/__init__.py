"""Reference solutions by the five equations of the paper, its statements judged, and methods compared."""
