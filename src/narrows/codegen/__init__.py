"""One traced system of terms, water, actuators, law and contact; what is printed and compiled of it."""
