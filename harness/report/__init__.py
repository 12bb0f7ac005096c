"""Results of studies as one page of HTML."""
