"""Readers of tables: text in any dialect, Parquet, Excel, data frames; units and other names in headers."""
