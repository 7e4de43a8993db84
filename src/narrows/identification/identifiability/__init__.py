"""What the tests can tell at all: rank and collinearity, influence of each test, and the verdicts."""
