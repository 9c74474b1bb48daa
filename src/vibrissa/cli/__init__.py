"""The command line: a file for each command.

Reads arguments and files, calls the package, writes results; it decides nothing.
"""
