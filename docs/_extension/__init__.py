"""What the site makes of the package itself while it is built: tables, commands, schemas, modules and pictures."""
