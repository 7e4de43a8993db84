"""Alerts as IEC 62923 has them: how sure, how urgent, who has heard; logged before they are published."""
