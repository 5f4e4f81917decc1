"""What touches first: all teeth, edges and fillets included."""
