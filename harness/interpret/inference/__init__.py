"""From the inputs of a layer to draws of its strength: simulated clay, measurements, real clay."""
