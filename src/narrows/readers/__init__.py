"""Readers of tables: text in any dialect, Parquet, Excel, MATLAB, data frames; units and other names in headers."""
