"""Pictures, pages and tables: what people look at before they read."""
