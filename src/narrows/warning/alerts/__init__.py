"""Alerts by IEC 62923: certainty, priority and acknowledgement; logged before publication."""
