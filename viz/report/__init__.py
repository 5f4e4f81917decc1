"""`render-report`: a design on one page for the browser."""
