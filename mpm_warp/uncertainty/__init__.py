"""What is known of the error of a result, of a cone, a sounding, a ball or a T-bar."""
