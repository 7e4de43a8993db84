"""Layouts of tables of captive tests, a file each."""
