"""Tables of terms: hydrodynamic derivatives, forms of the bank term, rudder and propeller."""
