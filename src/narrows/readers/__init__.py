"""Tables in: text in any dialect, Parquet, Excel, MATLAB, data frames; headers with units, columns by other names."""
