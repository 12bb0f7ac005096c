"""What pictures are made of: values, symbols, captions, style, files."""
