"""Ball and T-bar: soil flows around them on all sides."""
