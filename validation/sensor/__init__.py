"""Recordings of a bench with mistakes, and what is read from them."""
