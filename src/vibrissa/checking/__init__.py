"""Comparison: the tables of a study with reference tables, with another study, and with proofs."""

from vibrissa.extras import require

require("tables", "pandas", "yaml")
