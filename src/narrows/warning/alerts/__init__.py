"""Alerts as IEC 62923 has them: certainty, priority and acknowledgement; logged before publication."""
