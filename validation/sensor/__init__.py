"""Simulated recordings of a bench with set-up errors, and the friction identified from them."""
