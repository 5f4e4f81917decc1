"""Operation: first contact of all teeth, edges and fillets, and results that follow from it."""
