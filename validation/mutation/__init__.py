"""Small faults put into the code: which of them do the tests notice?."""
