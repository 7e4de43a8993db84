"""How well warnings do: what stood how long before a contact, and what was raised where nothing came of it."""
