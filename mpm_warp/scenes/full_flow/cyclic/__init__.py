"""Bodies that go down and up again in the same soil."""
