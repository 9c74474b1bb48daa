"""One web page of a study: tables, figures, animation and the paper's claims."""
