"""Parquet files as files: what stands at their end, and their digests."""
