"""A model as one table of terms: the term, the tables that come with the package, the forms of the bank term."""
