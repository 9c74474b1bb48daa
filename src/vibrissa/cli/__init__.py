"""The command line, with a module for each command.

A command reads arguments and files, calls the package, and writes the results.
"""
