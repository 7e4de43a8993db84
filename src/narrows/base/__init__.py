"""What every other package uses: errors, files, progress, results and names of other libraries."""
