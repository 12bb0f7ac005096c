"""Bodies that soil flows around on all sides."""
