"""Before a recording is read: its ends, the hum of the mains, slips that last a while."""
