"""Five scenes of ten minutes, fleets of drawn truths that sail through them, and the helms that steer these."""
