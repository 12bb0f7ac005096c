"""States of rest of elastic soil."""
