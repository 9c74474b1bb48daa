"""Comparison of the tables of a study with reference tables, other results, and proofs."""

from vibrissa.extras import require

require("tables", "pandas", "yaml")
