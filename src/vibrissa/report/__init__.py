"""One web page of a study: tables, figures, the explorer and the paper's claims."""

from vibrissa.extras import require

require("workflow", "jinja2")
