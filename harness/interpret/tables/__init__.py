"""What is read from tables: factors of simulated clay, and how far real clay departs from them."""
